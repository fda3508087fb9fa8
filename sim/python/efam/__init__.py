"""efam: a cantilevered fluidic artificial muscle, simulated, calibrated and diagnosed.

>>> import efam
>>> run = efam.simulate("scenarios/release-15psi.toml", payload="20 g")
>>> print(run)
"""

from ._answers import (
    Answer,
    Posterior,
    Residuals,
    Sweep,
    analyse,
    calibrate,
    check,
    compare,
    diagnose,
    effects,
    figures,
    fit_pressure_line,
    load,
    modes,
    plan,
    predict,
    predict_grid,
    sample,
    statics,
    sweep,
)
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
from ._fmu import to_fmu
from ._options import ExperimentOptions, Options
from ._recording import Recording
from ._run import Animation, Many, Run, simulate, simulate_many

__all__ = [
    "Animation",
    "Answer",
    "DataError",
    "EfamError",
    "Experiment",
    "ExperimentOptions",
    "Linear",
    "Many",
    "Model",
    "Options",
    "OutputError",
    "Posterior",
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
    "compare",
    "diagnose",
    "effects",
    "figures",
    "fit_pressure_line",
    "load",
    "modes",
    "plan",
    "predict",
    "predict_grid",
    "sample",
    "simulate",
    "simulate_many",
    "statics",
    "sweep",
    "to_fmu",
]
