"""Draws from the posterior of a calibration, beside its own intervals and ArviZ."""

import pickle
import time

import efam
import numpy as np
import pytest

from conftest import ROOT

EXPERIMENT = ROOT / "scenarios" / "diagnosis" / "nothing" / "experiment.toml"


@pytest.fixture(scope="module")
def drawn():
    """A short recording of a stiff rod, so that runs are short."""
    model = efam.Model(ROOT / "scenarios" / "release-15psi.toml", duration="3 s")
    run = efam.simulate(model, error_estimate=False)
    noise = np.random.default_rng(1).normal(0, 3e-4, run.tip.shape)
    recording = efam.Recording(times=run.t, markers={"tip": run.tip + noise})
    return efam.Experiment(
        muscle={"name": "garbulinski-2022"},
        effects={"rayleigh_mass": {"alpha": "0.8 1/s"}, "rayleigh_stiffness": {"beta": "3 ms"}},
        recording={"file": recording, "pressure": "15 psi", "tip": "tip", "up": "+z", "along": "+x", "angle": 0.0,
                   "offset": "none", "instants": ["0 s"]},
        calibrate={"parameter": [{"path": "rod.bending_stiffness"}, {"path": "effects.rayleigh_mass.alpha"},
                                 {"path": "effects.rayleigh_stiffness.beta"}]},
    )


def test_draws_have_the_spread_of_the_calibration(drawn, capsys):
    begin = time.perf_counter()
    found = efam.sample(drawn, chains=2, draws=150, warm_up=40, seed=3, progress=False)
    with capsys.disabled():
        print(f"\n{found['evaluations']} evaluations, {time.perf_counter() - begin:.1f} s\n{found}")
    calibration = efam.calibrate(drawn, progress=False)
    names = [own["name"] for own in found["parameters"]]
    assert len(names) == len(calibration["parameters"]) == 3 and found["divergent"] == 0
    for own, due in zip(found["parameters"], calibration["parameters"]):
        assert own["name"].startswith(due["name"])
        assert own["laplace_95"] == due["interval_95"]
        draws = found.draws[own["name"]]
        assert draws.shape == (2, 150) and draws.mean() == pytest.approx(own["value"])
        # The error of a deviation by 200 draws is 5 %, and that of a mean 7 % of it; the posterior is not quite normal.
        assert draws.std() == pytest.approx(due["standard_error"], rel=0.3), own["name"]
        assert abs(draws.mean() - due["value"]) < 0.4 * due["standard_error"], own["name"]
        # A draw in two is independent of the last one, though alpha and beta of one release are known as a sum.
        assert own["r_hat"] < 1.03 and own["effective_draws"] > 150, own["name"]
    least = min(own["effective_draws"] for own in found["parameters"])
    assert least > 400 or any("are worth" in warning for warning in found["warnings"])
    assert found.log_likelihood.keys() == set(found["releases"])
    assert np.array_equal(pickle.loads(pickle.dumps(found)).draws[names[0]], found.draws[names[0]])
    again = efam.sample(drawn, chains=2, draws=150, warm_up=40, seed=3, progress=False)
    assert np.array_equal(again.draws[names[0]], found.draws[names[0]]), "the same seed draws the same"


def test_arviz_agrees(drawn):
    arviz = pytest.importorskip("arviz")
    found = efam.sample(drawn, chains=2, draws=60, warm_up=20, progress=False)
    tree = found.to_arviz()
    for own in found["parameters"]:
        draws = tree["posterior"][own["name"]]
        assert draws.attrs["units"] == own["unit"]
        assert float(arviz.rhat(draws.values)) == pytest.approx(own["r_hat"], abs=2e-3)
        assert float(arviz.ess(draws.values)) == pytest.approx(own["effective_draws"], rel=0.02)
    own = found["nuisances"][0]
    instant = tree["prior"][own["name"]]
    assert own["name"].startswith("release instant") and instant.shape == (2, 60) and instant.attrs["units"] == "s"
    [marker] = found["markers"]
    name = f"tip of {found['releases'][0]}"
    recorded, predicted = tree["observed_data"][name].values, tree["posterior_predictive"][name]
    assert predicted.shape == (2, 10, len(marker["time_s"]), 2) and predicted.attrs["units"] == "m"
    # Two noises of 0.3 mm: that of the recording, in 600 residuals, and that of the prediction.
    assert (predicted.values - recorded).std() == pytest.approx(2**0.5 * 3e-4, rel=0.1)
    assert tree["log_likelihood"][found["releases"][0]].shape == (2, 60)


def test_a_fit_at_a_bound_is_sampled_inside(drawn):
    """The true alpha is 1 1/s; draws pile up at the lower bound and do not pass it."""
    bounded = efam.Experiment(drawn, calibrate={"parameter": [
        {"path": "rod.bending_stiffness"},
        {"path": "effects.rayleigh_mass.alpha", "bounds": ["1.2 1/s", "5 1/s"]},
        {"path": "effects.rayleigh_stiffness.beta"},
    ]})
    found = efam.sample(bounded, chains=2, draws=100, warm_up=40, progress=False)
    draws = found.draws["effects.rayleigh_mass.alpha at 103.4 kPa"]
    assert 1.2 <= draws.min() < 1.21 and draws.max() < 1.5, (draws.min(), draws.max())


def test_what_cannot_be_sampled_is_refused(drawn):
    with pytest.raises(efam.ScenarioError, match="chains = 1"):
        efam.sample(drawn, chains=1)


def test_a_pressure_line_is_found_back(scenario):
    line = {"effects.pressure_line.time_constant": 0.08, "effects.pressure_line.dead_time": 0.03}
    times, pressures = [0.0, 0.5, 0.51, 2.0], [1e5, 1e5, 2e5, 2e5]
    table = [[f"{t} s", f"{p} Pa"] for t, p in zip(times, pressures)]
    run = efam.simulate(scenario, pressure=table, duration="2 s", **line)
    reading, command = run["pressure_Pa"], np.interp(run.t, times, pressures)
    noise = np.random.default_rng(2).normal(0, 300, len(run.t))
    found = efam.fit_pressure_line(run.t, command, reading + noise)
    for path, due in line.items():
        own = found[path.rsplit(".", 1)[1] + "_s"]
        assert abs(own["value"] - due) < 4 * own["standard_error"] < 0.01, str(found)
    assert found["rate_limit_pa_per_s"] is None and "none up to" in str(found)
    assert efam.Model(scenario, **found["options"])["effects.pressure_line.dead_time"] == found["dead_time_s"]["value"]
    with pytest.raises(efam.DataError, match="never changes"):
        efam.fit_pressure_line(run.t, np.full(len(run.t), 1e5), reading)
