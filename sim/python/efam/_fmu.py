"""Functional mock-up units (FMI 3.0, co-simulation) of a rod, by PythonFMU3: for FMPy, Simulink and Modelica tools."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from ._efam import EfamError, Model
from ._extras import optional
from ._run import Source, model_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import Options

MODEL = "model.json"
PRESSURE = "rod.pressure"
KINDS = ("kinetic", "elastic", "potential")
FORCES = {f"effects.tip_load.{name}": name for name in ("force_x", "force_z", "moment")}
OUTPUTS = (("tip_x", "m"), ("tip_z", "m"), ("tip_vx", "m/s"), ("tip_vz", "m/s")) + tuple(
    (f"{kind}_energy", "J") for kind in KINDS
)
# The script that PythonFMU3 runs in the unit: it looks for a class of this base in its text.
SCRIPT = """from pythonfmu3 import Fmi3Slave
from efam._fmu import Unit

class Rod(Unit, Fmi3Slave):
    pass
"""
BASE = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
}


def to_fmu(
    scenario: Source,
    /,
    file: Union[str, os.PathLike[str]],
    *,
    overwrite: bool = False,
    **options: Unpack[Options],
) -> Path:
    """Writes a model as a functional mock-up unit (FMI 3.0, co-simulation): its path.

    Inputs are force_x, force_z and moment at the end of the rod, and pressure of a muscle; outputs the tip and energies. All
    else of the model is a parameter by its path, fixed at initialisation. The unit runs in Python: the tool that simulates it
    needs a Python with this package.
    """
    builder = optional("pythonfmu3").FmuBuilder
    model = model_of(scenario, **options)
    if not set(FORCES) <= set(model.parameters):
        model = model.replace(**{path: 0.0 for path in FORCES})
    target = Path(file)
    if target.suffix != ".fmu":
        raise TypeError(f"{target}: a unit is a file such as rod.fmu")
    if target.exists() and not overwrite:
        raise FileExistsError(f"{target}: exists; overwrite=True replaces it")
    # Beside the file, so that a unit is there whole or not at all.
    with tempfile.TemporaryDirectory(prefix=".efam-", dir=target.parent) as folder:
        work = Path(folder)
        # What a pickle of the model has.
        (work / MODEL).write_text(json.dumps(model.__reduce__()[1], default=os.fspath), encoding="utf-8")
        (work / "rod.py").write_text(SCRIPT, encoding="utf-8")
        can = {"canGetAndSetFMUState": True, "canSerializeFMUState": True}
        built = builder.build_FMU(work / "rod.py", dest=work / "built", project_files=[work / MODEL], **can)
        shutil.move(built, target)
    return target


class Unit:
    """What a unit does: the part of it that is not PythonFMU3's."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        fmi = optional("pythonfmu3")
        self._result: Any = fmi.Fmi3StepResult
        self._failed: Any = fmi.Fmi3Status.error
        self._model = Model._restore(*json.loads((Path(str(kwargs["resources"])) / MODEL).read_text("utf-8")))
        self._swing = self._model.start()
        self._given: dict[str, float] = {}
        """What was set and is not yet in the rod, by its path."""
        self._inputs = {**FORCES, **self._pressure()}
        own: Any = self
        own.modelName = re.sub(r"\W", "_", self._model.name)
        own.description = f"The rod {self._model.name} of efam, stepped."
        units = self._model.units
        own.register_units([_unit(fmi, unit) for unit in sorted({*units.values(), *dict(OUTPUTS).values()} - {""})])
        kinds, ways = fmi.Fmi3Causality, fmi.Fmi3Variability

        def register(name: str, kind: Any, way: Any, unit: str, get: Callable[[], float], put: Any = None) -> None:
            start = {"start": get()} if put else {}
            variable = fmi.Float64(
                name, causality=kind, variability=way, unit=unit or None, getter=get, setter=put, **start
            )
            own.register_variable(variable, nested=False)

        register("time", kinds.independent, ways.continuous, "s", lambda: self._swing.time)
        for path, name in self._inputs.items():
            register(name, kinds.input, ways.continuous, units[path], self._getter(path), self._setter(path))
        for name, unit in OUTPUTS:
            register(name, kinds.output, ways.continuous, unit, partial(self._output, name))
        for path in sorted(set(units) - set(self._inputs)):
            register(path, kinds.parameter, ways.fixed, units[path], self._getter(path), self._setter(path))

    def _pressure(self) -> dict[str, str]:
        """The pressure as an input, of a muscle whose scenario gives none over time."""
        try:
            self._swing.set(pressure=self._swing[PRESSURE])
        except EfamError:
            return {}
        return {PRESSURE: "pressure"}

    def _getter(self, path: str) -> Callable[[], float]:
        return lambda: self._given.get(path, self._swing[path])

    def _setter(self, path: str) -> Callable[[float], None]:
        def put(value: float) -> None:
            # A tool that sets all values as they are written, with 16 digits, changes nothing.
            if math.isclose(value, self._swing[path], rel_tol=1e-14):
                self._given.pop(path, None)
            else:
                self._given[path] = value

        return put

    def _output(self, name: str) -> float:
        if name.endswith("_energy"):
            return self._swing.energy[KINDS.index(name.removesuffix("_energy"))]
        position, velocity = self._swing.tip
        return float((velocity if "_v" in name else position)["xz".index(name[-1])])

    def _options(self) -> dict[str, Any]:
        """What was set since the last step, as options."""
        given, self._given = self._given, {}
        return {"pressure" if path == PRESSURE else path: value for path, value in given.items()}

    def exit_initialization_mode(self) -> None:
        """Starts the rod with the parameters and inputs that were set."""
        self._swing = self._model.replace(**self._options()).start()

    def do_step(self, current_time: float, step_size: float) -> Any:
        """Goes on by a step with the inputs as they are."""
        try:
            if self._given:
                self._swing.set(**self._options())
            self._swing.step(step_size)
        except EfamError as error:
            own: Any = self
            own.log(str(error), self._failed)
            return self._result(status=self._failed)
        return self._result()

    def _get_fmu_state(self) -> dict[str, Any]:
        inputs = {path: self._getter(path)() for path in self._inputs}
        return {"inputs": inputs, "state": self._swing.state}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        for path, value in state["inputs"].items():
            self._setter(path)(value)
        if self._given:
            self._swing.set(**self._options())
        time, q, v, z = state["state"]
        self._swing.state = (time, q, v, z)

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        return json.dumps(state).encode()

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(state)
        return found


def _unit(fmi: Any, name: str) -> Any:
    """A unit such as kg m^2 or 1/s by its base units."""
    powers: dict[str, int] = {}
    above, _, below = name.partition("/")
    for sign, part in ((1, above), (-1, below)):
        for symbol, power in re.findall(r"([A-Za-z]+)(?:\^(-?\d+))?", part):
            for base, own in BASE.get(symbol, {symbol: 1}).items():
                powers[base] = powers.get(base, 0) + sign * own * int(power or 1)
    return fmi.Unit(name, **powers)
