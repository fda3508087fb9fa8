"""What a call from Python costs beside the simulation; figures are printed, not asserted: other work shares the cores."""

import time

import efam
import pytest


def test_a_loop_costs_what_its_simulations_cost(scenario, capsys):
    model = efam.Model(scenario)
    calls = 100
    begin = time.perf_counter()
    runs = [efam.simulate(model, error_estimate=False) for _ in range(calls)]
    whole = time.perf_counter() - begin
    tips = [run.tip for run in runs]
    arrays = time.perf_counter() - begin - whole
    own = sum(run.summary["wall_time_s"] for run in runs)
    assert len(tips) == calls and own == pytest.approx(whole, rel=1)
    with capsys.disabled():
        print(f"\n{calls} runs of 20 s: {whole / own:.3f} times the core's time, {1e3 * own / calls:.2f} ms each, "
              f"and {1e3 * arrays / calls:.2f} ms for the arrays of one")
