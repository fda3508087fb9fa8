"""efam: a cantilevered fluidic artificial muscle, simulated, calibrated and diagnosed.

>>> import efam
>>> run = efam.simulate("scenarios/release-15psi.toml", payload="20 g")
>>> print(run)
"""

from ._answers import Answer, Residuals, Sweep, analyse, calibrate, check, diagnose, predict, sweep
from ._efam import (
    DataError,
    EfamError,
    Linear,
    Model,
    OutputError,
    ScenarioError,
    SimulationError,
    Swing,
    __version__,
)
from ._experiment import Experiment
from ._recording import Recording
from ._run import Many, Run, simulate, simulate_many

__all__ = [
    "Answer",
    "DataError",
    "EfamError",
    "Experiment",
    "Linear",
    "Many",
    "Model",
    "OutputError",
    "Recording",
    "Residuals",
    "Run",
    "ScenarioError",
    "SimulationError",
    "Sweep",
    "Swing",
    "__version__",
    "analyse",
    "calibrate",
    "check",
    "diagnose",
    "predict",
    "simulate",
    "simulate_many",
    "sweep",
]
