"""efam: a cantilevered fluidic artificial muscle, simulated, calibrated and diagnosed.

>>> import efam
>>> run = efam.simulate("scenarios/release-15psi.toml", payload="20 g")
>>> print(run)
"""

from ._answers import Answer, calibrate, diagnose, predict
from ._efam import (
    DataError,
    EfamError,
    Model,
    OutputError,
    Residuals,
    ScenarioError,
    SimulationError,
    Swing,
    __version__,
)
from ._run import Many, Run, simulate, simulate_many

__all__ = [
    "Answer",
    "DataError",
    "EfamError",
    "Many",
    "Model",
    "OutputError",
    "Residuals",
    "Run",
    "ScenarioError",
    "SimulationError",
    "Swing",
    "__version__",
    "calibrate",
    "diagnose",
    "predict",
    "simulate",
    "simulate_many",
]
