"""Linear models: against python-control, scipy, numpy and the nonlinear rod; the files of `efam linearise`."""

import ctypes
import json
import subprocess
import sys

import control
import efam
import numpy as np
import pytest
import scipy.io
import scipy.signal

DAMPED = {"effects.rayleigh_mass.alpha": 2.0}


@pytest.fixture
def model(scenario):
    return efam.Model(scenario, pressure="30 psi", **DAMPED, **{"rod.nodes": 8})


def test_poles_are_those_of_control_and_numpy(model):
    linear = model.linearise(outputs=["tip_z"])
    assert linear.inputs == ["pressure"] and linear.units["pressure"] == "Pa"
    assert linear.at_rest["pressure"] == pytest.approx(206842.7, abs=1)
    assert linear.A.shape == (len(linear.states), len(linear.states)) and linear.B.shape == (len(linear.states), 1)
    # Of a matrix whose poles are five decades apart, numpy has the slow ones to some 1e-8.
    ours = linear.poles
    for theirs in (control.poles(linear.to_control()), np.linalg.eigvals(linear.A)):
        for pole in ours[:6]:
            assert np.min(np.abs(theirs - pole)) < 1e-5 * abs(pole), (pole, theirs)
    small = linear.reduce(6)
    frequencies, ratios, poles = control.damp(small.to_control(), doprint=False)
    for pole in small.poles:
        k = np.argmin(np.abs(poles - pole))
        assert poles[k] == pytest.approx(pole, rel=1e-9)
        assert frequencies[k] == pytest.approx(abs(pole), rel=1e-9)
        assert ratios[k] == pytest.approx(-pole.real / abs(pole), rel=1e-9)


def test_responses_are_those_of_control_and_scipy(model):
    linear = model.linearise(inputs=["force_z"], outputs=["tip_x", "tip_z"])
    small = linear.reduce(6)
    assert small.static_gain == pytest.approx(linear.static_gain, rel=1e-6)
    assert np.all(np.abs(small.error_bound) < 0.1 * np.abs(linear.static_gain))
    assert np.squeeze(control.dcgain(small.to_control())) == pytest.approx(small.static_gain[:, 0], rel=1e-9)
    times = np.arange(200) * 0.01
    force = np.sin(7 * times)[None, :]
    own = small.discrete("10 ms")
    assert own.sample == 0.01 and own.to_control().dt == 0.01
    due = np.asarray(control.forced_response(own.to_control(), times, force).outputs)
    x, y = np.zeros(6), []
    for u in force[0]:
        y.append(own.C @ x + own.D[:, 0] * u)
        x = own.A @ x + own.B[:, 0] * u
    assert np.array(y).T == pytest.approx(due, abs=1e-9 * np.max(np.abs(due)))
    a, b, *_ = scipy.signal.cont2discrete((small.A, small.B, small.C, small.D), 0.01)
    assert own.A == pytest.approx(a, abs=1e-9) and own.B == pytest.approx(b, abs=1e-9 * np.max(np.abs(b)))
    assert own.to_scipy().dt == 0.01 and small.to_scipy().A.shape == (6, 6)


@pytest.mark.parametrize("force, off", [(0.02, 0.04), (0.002, 0.004)])
def test_a_small_step_is_that_of_the_nonlinear_rod(model, force, off):
    """A force that lifts the tip by 1 mm, held from rest: the error falls with the step."""
    rest = model.replace(**{"release.from": "equilibrium", "effects.tip_load.force_z": 0.0})
    linear = rest.linearise(inputs=["force_z"], outputs=["tip_z"]).discrete(0.02)
    swing = rest.start()
    height = [swing.tip[0][1]]
    swing.set(**{"effects.tip_load.force_z": force})
    for _ in range(150):
        swing.step(0.02)
        height.append(swing.tip[0][1])
    times = 0.02 * np.arange(151)
    due = control.forced_response(linear.to_control(), times, np.full((1, 151), force)).outputs
    found = np.array(height) - height[0]
    error = np.max(np.abs(found - np.squeeze(np.asarray(due)))) / np.max(np.abs(found))
    assert 0.5 * off < error < off, error


def test_what_cannot_be_is_refused(model):
    for inputs, message in ((["presure"], "did you mean `pressure`"), (["rod.length"], "no input")):
        with pytest.raises(efam.ScenarioError, match=message):
            model.linearise(inputs=inputs)
    linear = model.linearise()
    with pytest.raises(efam.ScenarioError, match="1..="):
        linear.reduce(0)
    with pytest.raises(efam.ScenarioError, match="samples already"):
        linear.discrete(0.01).discrete(0.01)
    with pytest.raises(efam.ScenarioError, match="longer than zero"):
        linear.discrete(0)


def test_the_files_of_the_command_hold_the_model(scenario, tmp_path):
    folder = tmp_path / "out"
    command = [sys.executable, "-m", "efam", "linearise", str(scenario), "--reduce", "4", "--sample", "10ms"]
    done = subprocess.run([*command, "--out", str(folder), "--json"], capture_output=True, text=True, check=True)
    answer = json.loads(done.stdout)["linear"]
    own = efam.Model(scenario).linearise()
    assert np.array_equal(own.A, answer["continuous"]["a"])
    discrete = answer["reduced"]["discrete"]

    mat = scipy.io.loadmat(folder / "linear.mat", squeeze_me=True)
    assert np.array_equal(mat["A"], own.A) and str(mat["inputs"]) == "pressure"
    assert str(mat["outputs"]).split("\n") == ["tip_x", "tip_z"]
    assert mat["reduced_discrete"]["sample_s"] == 0.01
    assert np.array_equal(mat["reduced_discrete"]["A"].item(), discrete["a"])

    source, library = tmp_path / "step.c", tmp_path / "step.so"
    source.write_text(
        f'#include "{folder}/linear.h"\n'
        "void run(double *x, const double *u, double *y, int n)\n"
        "{ for (int k = 0; k < n; k++) efam_step(x, u + k * EFAM_INPUTS, y + k * EFAM_OUTPUTS); }\n"
    )
    compiler = ["cc", "-Wall", "-Werror", "-shared", "-fPIC", "-o", str(library), str(source)]
    subprocess.run(compiler, check=True)
    count = 300
    pressure, x, y = np.full(count, 1000.0), np.zeros(4), np.zeros((count, 2))
    pointers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (x, pressure, y)]
    ctypes.CDLL(str(library)).run(*pointers, count)
    a, b, c, d = (np.array(discrete[key]) for key in "abcd")
    system = scipy.signal.dlti(a, b, c, d, dt=0.01)
    due = scipy.signal.dlsim(system, pressure)[1]
    assert y == pytest.approx(due, abs=1e-12 * np.max(np.abs(due)))
