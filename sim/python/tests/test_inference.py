"""Calibration and prediction: the program's own answers, and solvers of Python on the same residuals."""

import json
import subprocess
import time

import efam
import numpy as np
import pytest
from scipy.optimize import least_squares, minimize

from conftest import EFAM, ROOT

EXPERIMENT = ROOT / "scenarios" / "diagnosis" / "nothing" / "experiment.toml"


def printed(tmp_path, *command):
    done = subprocess.run([*EFAM, *command, "--json"], cwd=tmp_path, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_a_grid_and_a_plan_are_those_of_the_program(scenario, tmp_path):
    grid = efam.predict_grid(scenario, pressures=["30 psi", "15 psi"], payloads=[0, "20 g"], **{"rod.nodes": 8})
    command = ["predict", str(scenario), "--pressure", "15psi,30psi", "--payload", "0g,20g", "--set", "rod.nodes=8"]
    due = printed(tmp_path, *command)["grid"]
    assert len(grid["cells"]) == 4 and grid["cells"] == due["cells"]
    assert "psi" in str(grid)

    short = efam.Model(scenario, duration="1 s", **{"rod.nodes": 8})
    plan = efam.plan(short, noise="0.1 mm")
    command = ["diagnose", "--plan", str(scenario), "--noise", "0.1 mm", "--set", "run.duration=1 s",
               "--set", "rod.nodes=8"]
    assert plan["prospects"] == printed(tmp_path, *command)["prospects"] and plan["releases"] == 1
    with pytest.raises(efam.ScenarioError, match="more than nothing"):
        efam.plan(short, noise=0.0)


def test_figures_are_those_of_the_program(tmp_path):
    found = efam.figures()
    assert found["figures"] == printed(tmp_path, "figures", "--out", str(tmp_path / "figures"))["figures"]
    assert (found.write(tmp_path / "own") / "figure-8.csv").read_bytes() == (
        tmp_path / "figures" / "figure-8.csv"
    ).read_bytes()
    with pytest.raises(efam.ScenarioError, match="every pressure of its table"):
        efam.figures(**{"muscle.pressure": "15 psi"})


def test_a_prediction_is_that_of_the_program(tmp_path):
    command = [*EFAM, "predict", "--muscle", "garbulinski-2022", "--pressure", "15psi", "--payload", "20g", "--json",
               "--draws", "8", "--out", str(tmp_path / "prediction")]
    printed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    prediction = efam.predict("garbulinski-2022", pressure="15 psi", payload="20 g", draws=8)
    same = [key for key in prediction if key not in ("name", "scenario")]
    assert {key: prediction[key] for key in same} == {key: printed["prediction"][key] for key in same}
    assert "frequency" in str(prediction)


def test_the_jacobian_is_that_of_the_residuals():
    residuals = efam.Residuals(EXPERIMENT)
    theta = residuals.start
    low, high = residuals.bounds
    assert ((low <= theta) & (theta <= high)).all() and len(residuals.names) == len(residuals.units) == len(theta)
    r, jacobian = residuals.residuals_and_jacobian(theta)
    exact = residuals.residuals_and_jacobian(theta, exact=True)[1]
    assert jacobian.shape == exact.shape == (len(r), len(theta))
    for k in range(len(theta)):
        step = 1e-4 * (abs(theta[k]) if theta[k] else 1e-2)
        ends = [theta + sign * step * (np.arange(len(theta)) == k) for sign in (1, -1)]
        up, down = (residuals.residuals_and_jacobian(end)[0] for end in ends)
        difference = (up - down) / (2 * step)
        size = np.linalg.norm(difference)
        # On the same steps differences agree to three digits: a later release moves samples from one step to the next.
        # Variational slopes are those of the exact solution.
        assert np.linalg.norm(difference - exact[:, k]) < 5e-3 * size, residuals.names[k]
        assert np.linalg.norm(difference - jacobian[:, k]) < 0.15 * size, residuals.names[k]
    # Where losses are a hundredth and the steps of the start are too long.
    far = np.where([name.startswith("effects.rayleigh") for name in residuals.names], 0.01 * theta, theta)
    exact, jacobian = residuals.residuals_and_jacobian(far, exact=True)
    assert np.isfinite(jacobian).all()
    assert np.abs(exact - residuals.residuals_and_jacobian(far)[0]).max() < 0.1


def test_scipy_lowers_the_residuals():
    residuals = efam.Residuals(EXPERIMENT)
    start = residuals.start
    begin = residuals.residuals_and_jacobian(start)[0]
    found = least_squares(
        lambda theta: residuals.residuals_and_jacobian(theta)[0],
        start,
        jac=lambda theta: residuals.residuals_and_jacobian(theta)[1],
        bounds=residuals.bounds,
        x_scale="jac",
        loss="soft_l1",
        max_nfev=10,
    )
    assert found.cost < 0.2 * np.sum(begin**2), (found.cost, np.sum(begin**2))
    with pytest.raises(efam.ScenarioError, match="finite numbers are due"):
        residuals.residuals_and_jacobian(start[:-1])


def test_a_simplex_finds_the_stiffness_back(scenario):
    model = efam.Model(scenario, duration="2 s")
    measured = efam.simulate(model, error_estimate=False)
    path = "rod.bending_stiffness"

    def misfit(theta):
        run = efam.simulate(model.replace(**{path: 1e-3 * theta[0]}), error_estimate=False)
        return np.sum((run.tip - measured.tip) ** 2)

    begin = time.perf_counter()
    found = minimize(misfit, [0.9e3 * model[path]], method="Nelder-Mead", options={"maxfev": 40, "xatol": 1e-7})
    print(f"{found.nfev} calls in {time.perf_counter() - begin:.3f} s")
    assert found.x[0] == pytest.approx(1e3 * model[path], rel=1e-4)


def test_calibrations_and_diagnoses_are_those_of_the_program(tmp_path):
    def printed(*arguments):
        command = [*EFAM, *arguments, str(EXPERIMENT), "--json", "--out", str(tmp_path / arguments[0])]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    found = efam.calibrate(EXPERIMENT)
    assert found["parameters"] == printed("calibrate")["calibration"]["parameters"]
    assert "rod.bending_stiffness" in str(found)
    diagnosed = efam.diagnose(EXPERIMENT, most=0)
    program = printed("diagnose", "--most", "0")["diagnosis"]
    assert diagnosed["verdict"] == program["verdict"] and diagnosed["rounds"] == program["rounds"]
