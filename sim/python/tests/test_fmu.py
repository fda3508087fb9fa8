"""A model as a functional mock-up unit, checked and simulated by FMPy."""

import shutil
import time

import efam
import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy")
pytest.importorskip("pythonfmu3")
from fmpy.fmi3 import FMU3Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402


@pytest.fixture
def unit(scenario, tmp_path):
    return efam.to_fmu(scenario, tmp_path / "rod.fmu", duration="2 s")


@pytest.fixture
def slave(unit):
    """The unit after its initialisation, with its value references by name."""
    description = fmpy.read_model_description(unit)
    folder = fmpy.extract(unit)
    own = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="rod",
    )
    own.instantiate()
    own.enterInitializationMode()
    own.exitInitializationMode()
    yield own, {variable.name: variable.valueReference for variable in description.modelVariables}
    own.terminate()
    own.freeInstance()
    shutil.rmtree(folder)


def error_of(found, run):
    """Largest distance of the tip from that of a run at its samples."""
    at = [np.argmin(np.abs(found["time"] - time)) for time in run.t]
    assert np.abs(found["time"][at] - run.t).max() < 1e-9
    return np.hypot(found["tip_x"][at] - run.tip[:, 0], found["tip_z"][at] - run.tip[:, 1]).max()


def test_a_unit_is_valid_and_follows_the_run(scenario, unit):
    assert validate_fmu(str(unit)) == []
    variables = {own.name: own for own in fmpy.read_model_description(unit).modelVariables}
    assert variables["tip_z"].unit == "m" and variables["rod.bending_stiffness"].unit == "N m^2"
    model = efam.Model(scenario, duration="2 s", **{"run.rate": "100 Hz"})
    of_run = {"stop_time": 2, "output_interval": 0.01, "output": ["tip_x", "tip_z"]}
    # Accuracy of the run and of the unit, 0.02 mm each.
    tolerance = 4e-5
    found = fmpy.simulate_fmu(str(unit), **of_run)
    assert error_of(found, efam.simulate(model)) < tolerance
    heavy = fmpy.simulate_fmu(str(unit), start_values={"effects.rayleigh_mass.alpha": 1.2}, **of_run)
    changed = efam.simulate(model, **{"effects.rayleigh_mass.alpha": 1.2})
    assert error_of(heavy, changed) < tolerance < error_of(heavy, efam.simulate(model))


def test_forces_and_pressure_move_it(scenario, unit):
    load = {"effects.tip_load.force_z": 0.1, "effects.tip_load.moment": 0.01}
    model = efam.Model(scenario, duration="1 s", **{"run.rate": "100 Hz"})
    of_run = {"stop_time": 1, "output_interval": 0.01, "output": ["tip_x", "tip_z"]}
    found = fmpy.simulate_fmu(str(unit), start_values={"force_z": 0.1, "moment": 0.01}, **of_run)
    assert error_of(found, efam.simulate(model, **load)) < 4e-5
    found = fmpy.simulate_fmu(str(unit), start_values={"pressure": 206842.72}, **of_run)
    assert error_of(found, efam.simulate(model, pressure=206842.72)) < 4e-5


def test_an_input_that_changes_is_that_of_a_swing(scenario, slave):
    own, references = slave
    swing = efam.Model(scenario, duration="2 s", **{"effects.tip_load.force_z": 0.0}).start()
    for step in range(40):
        force, pressure = 0.05 * np.sin(step), 103e3 + 1e3 * step
        own.setFloat64([references["force_z"], references["pressure"]], [force, pressure])
        swing.set(pressure=pressure, **{"effects.tip_load.force_z": force})
        own.doStep(0.01 * step, 0.01)
        swing.step(0.01)
    tip = own.getFloat64([references["tip_x"], references["tip_z"], references["tip_vz"]])
    assert np.allclose(tip, [*swing.tip[0], swing.tip[1][1]], rtol=0, atol=1e-12)


def test_a_state_is_kept_set_and_written(slave):
    own, references = slave
    tip = [references["tip_x"], references["tip_z"]]
    force = [references["force_z"]]

    def go(begin):
        for step in range(20):
            own.doStep(begin + 0.01 * step, 0.01)
        return own.getFloat64(tip)

    own.setFloat64(force, [0.02])
    go(0.0)
    state = own.getFMUState()
    written = own.serializeFMUState(state)
    after = go(0.2)
    own.setFloat64(force, [0.2])
    assert not np.allclose(go(0.4), after)
    for again in (state, own.deserializeFMUState(written)):
        own.setFMUState(again)
        # It goes on with a first step of its own.
        assert np.allclose(go(0.2), after, rtol=0, atol=2e-5)
        assert own.getFloat64(force) == [0.02]


def test_a_step_that_fails_is_an_error_of_the_unit(slave):
    own, references = slave
    own.setFloat64([references["pressure"]], [3e7])
    with pytest.raises(fmpy.fmi1.FMICallException, match="[Ee]rror"):
        own.doStep(0.0, 0.01)


def test_a_step_costs_little(slave):
    own, _ = slave
    begin = time.process_time()
    for step in range(1000):
        own.doStep(1e-3 * step, 1e-3)
    cost = 1e3 * (time.process_time() - begin)
    print(f"a step of 1 ms of a unit: {cost:.0f} microseconds")
    # A build for tests on a busy machine is some times slower than the wheel.
    assert cost < 500


def test_a_file_that_is_there_stays(scenario, unit):
    with pytest.raises(FileExistsError, match="overwrite"):
        efam.to_fmu(scenario, unit)
    assert efam.to_fmu(scenario, unit, overwrite=True) == unit
    with pytest.raises(TypeError, match="rod.fmu"):
        efam.to_fmu(scenario, unit.with_suffix(".zip"))
