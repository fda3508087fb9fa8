"""What batches cost in time and memory. Figures of time are printed: other work shares the cores.

EFAM_BATCH sets the size; 10000 gives the figures of docs/src/guide/python.md.
"""

import gc
import os
import resource
import time

import efam
import numpy as np
import pytest
from scipy.optimize import minimize

SIZE = int(os.environ.get("EFAM_BATCH", 200))


class Clock:
    """Wall-clock time and processor time since it was made, s."""

    def __init__(self):
        self.wall, self.cpu = time.perf_counter(), time.process_time()

    def __str__(self):
        return f"{time.perf_counter() - self.wall:.2f} s ({time.process_time() - self.cpu:.2f} s of processors)"


@pytest.fixture
def say(capsys):
    def said(text):
        with capsys.disabled():
            print(f"\n{text}", end="")

    return said


def resident():
    """Memory in use, MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


def test_a_loop_costs_what_its_simulations_cost(scenario, say):
    model = efam.Model(scenario)
    calls = max(SIZE // 10, 50)
    clock = Clock()
    runs = [efam.simulate(model, error_estimate=False) for _ in range(calls)]
    whole = time.perf_counter() - clock.wall
    own = sum(run.summary["wall_time_s"] for run in runs)
    say(f"loop of {calls} runs of 20 s: {clock}, {whole / own:.3f} times the core's time")
    assert whole < 1.2 * own, "what Python adds to a run"


def test_a_batch_is_one_array(scenario, say):
    model = efam.Model(scenario)
    clock = Clock()
    models = [model.replace(payload=0.1 * k / SIZE) for k in range(SIZE)]
    say(f"{SIZE} models: {clock}")
    clock = Clock()
    many = efam.simulate_many(models)
    say(f"{SIZE} releases of 20 s on {os.cpu_count()} cores: {clock}, {many.tip.nbytes / 1e6:.0f} MB")
    assert many.tip.shape == (SIZE, 2001, 2) and many.failures == {} and np.isfinite(many.tip).all()


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory in use is that of Linux")
def test_memory_stays_flat_over_many_calls(scenario, say):
    model = efam.Model(scenario, duration="0.2 s")

    def call(count):
        for _ in range(count):
            run = efam.simulate(model, error_estimate=False)
            run.data, run.summary
        gc.collect()
        return resident()

    before = call(max(SIZE // 10, 100))
    after = call(SIZE)
    say(f"memory after {SIZE} more calls: {after - before:+.1f} MB")
    # A leak of one run would be 10 kB a call.
    assert after - before < 2 + 1e-3 * SIZE, "MB"


def test_a_simplex_of_forty_calls(scenario, say):
    model = efam.Model(scenario, duration="2 s")
    measured = efam.simulate(model, error_estimate=False).tip
    path = "rod.bending_stiffness"

    def misfit(theta):
        own = model.replace(**{path: 1e-3 * theta[0]})
        return np.sum((efam.simulate(own, error_estimate=False).tip - measured) ** 2)

    clock = Clock()
    found = minimize(misfit, [0.9e3 * model[path]], method="Nelder-Mead", options={"maxfev": 40, "xatol": 1e-9})
    say(f"Nelder-Mead of {found.nfev} calls: {clock}")
    assert found.x[0] == pytest.approx(1e3 * model[path], rel=1e-4)
