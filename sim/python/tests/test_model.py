"""Models: copies, pickles, threads, errors, steps."""

import copy
import gc
import os
import pickle
import resource
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import efam
import numpy as np
import pytest


def test_copies_and_pickles_give_the_same_bits_without_files(scenario, tmp_path, monkeypatch):
    model = efam.Model(scenario, duration="0.5 s", payload="10 g")
    stored = pickle.dumps(model)
    monkeypatch.chdir(tmp_path)
    data = efam.simulate(model).data
    for other in (pickle.loads(stored), copy.copy(model), copy.deepcopy(model)):
        assert np.array_equal(efam.simulate(other).data, data)


def test_a_muscle_of_a_file_goes_with_its_pickle(scenario, tmp_path):
    text = scenario.parents[1].joinpath("models/muscles/garbulinski-2022.toml").read_text()
    muscle = tmp_path / "own.toml"
    muscle.write_text(text)
    model = efam.Model(scenario, muscle=muscle, duration="0.2 s")
    stored = pickle.dumps(model)
    muscle.unlink()
    assert pickle.loads(stored).text == model.text


def test_a_pool_of_threads_gives_the_bits_of_one(model):
    models = [model.replace(payload=0.005 * k) for k in range(8)]
    alone = [efam.simulate(own).data for own in models]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda own: efam.simulate(own).data, models))
    assert all(np.array_equal(a, b) for a, b in zip(alone, together))


def test_the_global_lock_is_released(scenario):
    model = efam.Model(scenario, duration="200 s")
    ticks = 0
    worker = threading.Thread(target=efam.simulate_many, args=([model] * 4,))
    worker.start()
    while worker.is_alive():
        ticks += 1
        time.sleep(0.001)
    assert ticks > 20, ticks


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
def test_ctrl_c_ends_a_run(scenario):
    # Without damping it never comes to rest, where steps would soon be long.
    undamped = {"effects.rayleigh_mass.alpha": "0 1/s", "effects.rayleigh_stiffness.beta": "0 s"}
    model = efam.Model(scenario, duration="10 h", **{"run.rate": "1 Hz"}, **undamped)
    # A shell that runs the tests in the background has switched it off.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        efam.simulate(model, error_estimate=False)


def test_memory_stays_flat(scenario):
    model = efam.Model(scenario, duration="0.2 s")

    def grown(calls):
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(calls):
            run = efam.simulate(model, error_estimate=False)
            run.data, run.summary
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before

    grown(100)
    # A leak of one run, a fifth of a second of 16 nodes, would be 10 kB a call.
    assert grown(500) < 2_000, "kB"


def test_a_swing_is_that_of_a_run(model):
    run = efam.simulate(model, error_estimate=False)
    swing = model.start()
    for _ in range(100):
        swing.step("10 ms")
    sample = np.argmin(np.abs(run.t - 1.0))
    assert swing.time == pytest.approx(1.0)
    # Both hold to the tolerance of their steps, which end at different times.
    assert np.abs(swing.tip[0] - run.tip[sample]).max() < 2e-5 + 1.5 * abs(run.t[sample] - 1.0)


def test_pressure_and_payload_change_while_it_swings(scenario):
    swing = efam.Model(scenario).start()
    swing.step(0.5)
    state, tip = swing.state, swing.tip
    swing.set(pressure="30 psi", payload=0.02)
    assert swing["effects.payload.mass"] == 0.02 and swing["rod.pressure"] == pytest.approx(206842.7)
    assert np.allclose(swing.tip[0], tip[0], atol=1e-3)
    swing.step(0.5)
    changed = swing.tip[0]
    swing.set(pressure="15 psi", payload=0)
    swing.state = state
    assert swing.time == 0.5
    swing.step(0.5)
    assert np.abs(swing.tip[0] - changed).max() > 1e-3
    with pytest.raises(efam.ScenarioError, match="no effect can be added"):
        swing.set(**{"effects.air_drag.drag_coefficient": 1.0})
    with pytest.raises(efam.ScenarioError, match="coordinates"):
        swing.state = (0.0, [1.0], [1.0], [])


def test_what_is_set_quickly_is_what_the_scenario_says(scenario):
    force = "effects.tip_load.force_z"
    swing = efam.Model(scenario, **{force: 0.0}).start()
    swing.step(0.1)
    said = {}
    for options in (
        {force: 0.02},
        {"pressure": "31 psi"},
        {"pressure": 2e5, force: "30 mN"},
        {"pressure": "22 psi"},
        {"payload": "10 g"},
        {"pressure": "23 psi"},
    ):
        swing.set(**options)
        said |= options
        due = efam.Model(scenario, **{force: 0.0}).replace(**said).parameters
        assert {path: swing[path] for path in due} == due, options
    with pytest.raises(efam.ScenarioError, match="outside the table"):
        swing.set(pressure="400 psi")
    with pytest.raises(efam.ScenarioError, match="must lie in"):
        swing.set(**{force: 1e7})


def test_behind_a_pressure_line_a_swing_follows_its_commands(scenario, tmp_path):
    """Three commands, two of them within the dead time: the run under them as a table of pressures."""
    line = {"effects.pressure_line.time_constant": "60 ms", "effects.pressure_line.dead_time": "30 ms"}
    commands = [(0.1, 20), (0.12, 18), (0.3, 25)]
    rows = [["0 s", "15 psi"], ["0.1 s", "15 psi"]]
    swing, last, tips = efam.Model(scenario, **line).start(), 0.0, []
    for time, psi in commands:
        swing.step(time - last)
        swing.set(pressure=f"{psi} psi")
        last = time
        if len(rows) > 2:
            rows.append([f"{time} s", rows[-1][1]])
        rows.append([f"{time + 1e-6:.6f} s", f"{psi} psi"])
    for _ in range(10):
        swing.step(0.05)
        tips.append(swing.tip[0])
    table = tmp_path / "table.toml"
    table.write_text(open(scenario).read().replace('"15 psi"', str(rows).replace("'", '"')))
    fine = {"run.rate": "1000 Hz", "run.duration": "1 s"}
    run = efam.simulate(table, error_estimate=False, **fine, **line)
    due = [run.tip[np.argmin(np.abs(run.t - 0.3 - 0.05 * (k + 1)))] for k in range(10)]
    # Both hold to the tolerance of their steps.
    assert np.abs(np.array(tips) - due).max() < 1e-4
    at_once = efam.simulate(table, error_estimate=False, **fine)
    assert np.abs(at_once.tip[-1] - run.tip[-1]).max() < np.abs(at_once.tip[350] - run.tip[350]).max() > 1e-3


def test_pressure_damps_a_swing(scenario):
    """The controller of the guide: at a higher pressure the tip rests lower, so pressure rises with the tip."""

    def swing_left(gain):
        swing, heights = efam.Model(scenario).start(), []
        for _ in range(500):
            swing.set(pressure=103e3 + 40e3 * max(-1, min(1, gain * swing.tip[1][1])))
            swing.step("10 ms")
            heights.append(swing.tip[0][1])
        return np.ptp(heights[-100:])

    assert swing_left(0.5) < 0.3 * swing_left(0) < 0.3 * swing_left(-0.1)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"payload": "20 m"}, efam.ScenarioError, "payload 20 m"),
        ({"payload": -1}, efam.ScenarioError, "must not be negative"),
        ({"pressure": "4000 psi"}, efam.ScenarioError, "pressure"),
        ({"effects.payload.mas": 1}, efam.ScenarioError, "did you mean `mass`"),
        ({"rod.length": float("nan")}, efam.ScenarioError, "rod.length"),
        ({"muscle": "nowhere.toml"}, efam.ScenarioError, "nowhere.toml"),
        ({"payload": [1]}, TypeError, "payload"),
        ({"rod.mass": None}, TypeError, "rod.mass"),
        ({"pressure": "all rows"}, efam.ScenarioError, "choose one"),
    ],
)
def test_errors_have_the_words_of_the_program(scenario, options, error, words):
    with pytest.raises(error) as met:
        efam.Model(scenario, **options)
    assert words in str(met.value)


def test_a_path_that_is_not_there():
    with pytest.raises(efam.ScenarioError, match="cannot be read"):
        efam.Model("nowhere.toml")


def test_no_argument_makes_it_panic(scenario):
    random = np.random.default_rng(1)
    keys = ["payload", "angle", "duration", "pressure", "muscle", "rod.nodes", "rod.length", "run.rate", "run",
            "effects", "effects.air_drag.drag_coefficient", "release.from", "release.nodes", "integrator.method",
            "", ".", "a=b", "rod.length[1]", "\x00", "é" * 40]
    deep: list = []
    for _ in range(50):
        deep = [deep]
    values = [0, -1, 1, 1e308, -1e308, float("inf"), float("nan"), True, None, "", "0 g", "x", "\x00", "1e400 m",
              [], [[]], deep, {}, {"a": {"b": 1}}, 10**400, b"bytes", object(), "held", "😀", np.zeros(3),
              np.float32(1), [[0, 1], [1, float("nan")]]]
    values.append({"self": values[-1]})
    met = set()
    for _ in range(3000):
        count = random.integers(1, 4)
        options = {keys[random.integers(len(keys))]: values[random.integers(len(values))] for _ in range(count)}
        try:
            efam.Model(scenario, **options)
        except Exception as error:
            met.add(type(error).__name__)
    assert met <= {"ScenarioError", "DataError", "SimulationError", "TypeError", "OverflowError", "ValueError"}, met
