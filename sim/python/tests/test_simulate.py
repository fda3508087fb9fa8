"""One run: the numbers of the program, as arrays."""

import json
import os
import re
import subprocess
import sys

import efam
import numpy as np
import pytest

from conftest import EFAM, ROOT

# The hour, the time that it took and the command differ.
OF_THE_CALL = {"argv", "wall_time_s", "real_time_factor", "written_utc", "inputs_sha256"}


def test_numbers_are_those_of_the_program_to_the_bit(scenario, tmp_path):
    out = tmp_path / "run"
    command = [*EFAM, "simulate", str(scenario), "--payload", "20g", "--json", "--csv", "--out", str(out)]
    printed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    run = efam.simulate(scenario, payload="20g")
    of_program = printed["runs"][0]
    assert set(run.summary) == set(of_program)
    for key in set(run.summary) - OF_THE_CALL:
        assert run.summary[key] == of_program[key], key
    table = np.genfromtxt(out / "trajectory.csv", delimiter=",", names=True)
    assert list(table.dtype.names) == run.columns
    assert all(np.array_equal(table[name], run[name]) for name in run.columns)
    assert (out / "scenario.resolved.toml").read_text() == run.text


def test_arrays_are_views_of_one(model):
    run = efam.simulate(model)
    samples, nodes = len(run.t), run.nodes.shape[1]
    assert run.nodes.shape == (samples, nodes, 2) and run.tip.shape == (samples, 2)
    assert all(np.shares_memory(own, run.data) for own in (run.t, run.tip, run.nodes, run.velocities))
    assert np.array_equal(run.nodes[:, 0], np.zeros((samples, 2))), "the clamp"
    assert np.array_equal(run.nodes[:, -1, 0], run[f"x_{nodes - 1:02}_m"])
    total = run.energies["total"]
    assert np.ptp(total) < 1e-3 * np.ptp(run.energies["kinetic"])


def test_units_are_texts_or_si(scenario):
    by_text = efam.simulate(scenario, payload="50 g", duration="1 s", error_estimate=False)
    by_number = efam.simulate(
        scenario, duration=1, error_estimate=False, **{"effects.payload.mass": np.float64(0.05)}
    )
    assert np.array_equal(by_text.data, by_number.data)


def test_a_model_of_tables_is_that_of_its_text():
    text = '[rod]\nlength = "0.2 m"\nmass = "30 g"\nbending_stiffness = "0.005 N m^2"\n[run]\nduration = "1 s"\n'
    rod = {"length": 0.2, "mass": "30 g", "bending_stiffness": 0.005}
    by_tables = efam.Model({"rod": rod, "run": {"duration": 1.0}})
    assert by_tables.text == efam.Model(text).text
    assert by_tables["rod.mass"] == 0.03 and by_tables.units["rod.mass"] == "kg"


LAW = {
    "place": "flow",
    "force": "-c * v_n * abs(v_n) * diameter",
    "parameters": {"c": {"unit": "kg/m^3", "default": 0.6, "range": [0, 10]}},
}


def test_a_number_for_a_law_as_text_is_si(scenario):
    text = scenario.read_text() + """
[laws.my_drag]
place = "flow"
force = "-c * v_n * abs(v_n) * diameter"
parameters.c = { unit = "kg/m^3", default = 0.6, range = [0, 10] }
"""
    path = "effects.my_drag.c"
    by_text = efam.Model(text, **{path: "800 g/m^3"})
    by_number = efam.Model(text, **{path: np.float64(0.8)})
    assert by_number.text == by_text.text and by_number[path] == 0.8
    # Of the model that it replaces, of tables, and of arguments beside it.
    assert by_text.replace(**{path: 1})[path] == 1.0
    of_tables = efam.Model({"laws": {"my_drag": LAW}, "effects": {"my_drag": {"c": 0.8}}, "muscle": MUSCLE})
    assert of_tables[path] == 0.8 and of_tables.replace(effects={"my_drag": {"c": 0.5}})[path] == 0.5
    beside = efam.Model(scenario, effects={"my_drag": {"c": 0.8}}, laws={"my_drag": LAW})
    assert beside[path] == 0.8
    swing = by_text.start()
    swing.set(**{path: 2.0})
    with pytest.raises(efam.ScenarioError, match="laws.my_drag"):
        efam.Model(text.replace("abs(v_n)", "abs(v_m)"), **{path: 0.8})


MUSCLE = {"name": "garbulinski-2022", "pressure": "15 psi"}


def test_a_number_for_a_law_of_an_experiment_is_si(scenario):
    file = scenario.parent / "diagnosis" / "nothing" / "experiment.toml"
    experiment = efam.Experiment(file, laws={"my_drag": LAW}, effects={"my_drag": {"c": 0.8}})
    assert 'effects.my_drag.c="0.8 kg/m^3"' in experiment.settings


def test_a_pressure_over_time(scenario):
    rows = [[0, 1e5], [1.0, 2e5]]
    by_number = efam.Model(scenario, pressure=rows)
    by_text = efam.Model(scenario, pressure=[["0 s", "100000 Pa"], ["1 s", "200000 Pa"]])
    assert by_number.text == by_text.text


def test_sensitivities_are_derivatives(model):
    path = "rod.bending_stiffness"
    run = efam.simulate(model, error_estimate=False, sensitivities=[path])
    step = 1e-4 * model[path]
    tips = [
        efam.simulate(model.replace(**{path: model[path] + sign * step}), error_estimate=False).tip
        for sign in (1, -1)
    ]
    difference = (tips[0] - tips[1]) / (2 * step)
    error = np.abs(run.sensitivity(path) - difference).max() / np.abs(difference).max()
    # Steps of the usual tolerance; see the documentation of Run::sensitivities.
    assert error < 0.03, error
    with pytest.raises(KeyError, match="not asked for"):
        run.sensitivity("rod.mass")


def test_what_other_packages_take(model):
    run = efam.simulate(model)
    frame = run.to_pandas()
    assert list(frame.columns) == run.columns and len(frame) == len(run.t)
    data = run.to_xarray()
    assert data["nodes"].dims == ("time", "node", "axis")
    assert len(run.plot()[1].lines) == 1
    page = run._repr_html_()
    assert page.startswith("<iframe srcdoc=") and "The swing" in page
    assert "frequency" in str(run) and "15psi" in repr(run).replace("-", "")


@pytest.mark.parametrize(
    "package, use",
    [
        ("matplotlib", lambda run: run.plot()),
        ("pandas", lambda run: run.to_pandas()),
        ("xarray", lambda run: run.to_xarray()),
        ("tqdm", lambda run: efam.simulate_many([], progress=True)),
    ],
)
def test_a_package_that_is_absent_is_named_with_its_extra(model, monkeypatch, package, use):
    run = efam.simulate(model, error_estimate=False)
    for name in [name for name in sys.modules if name.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=f"{package} is not installed: pip install {package}") as error:
        use(run)
    extra = str(error.value).split('".[')[1].split("]")[0]
    assert re.search(rf'^{extra} = \[.*"{package}>=', (ROOT / "pyproject.toml").read_text(), re.M)


def test_many_are_the_same_as_each(model):
    models = [model.replace(payload=mass) for mass in (0.0, 0.02, 0.05)]
    many = efam.simulate_many([*models, model.replace(duration=1)], rate=50)
    assert many.tip.shape == (4, 101, 2) and many.failures == {}
    for own, tip in zip(models, many.tip):
        alone = efam.simulate(own, error_estimate=False, **{"run.rate": "50 Hz"})
        assert np.array_equal(alone.tip, tip)
    assert np.isnan(many.tip[3, 51:]).all() and np.isfinite(many.tip[3, :51]).all()


FORKED = """
import multiprocessing, sys, warnings
import efam, numpy
warnings.simplefilter("ignore")
scenario, experiment = sys.argv[1:]
model = efam.Model(scenario, duration="1 s")

def work(_):
    run = efam.simulate(model)
    analysis = efam.analyse(experiment, nodes=[8])
    return run.data, efam.simulate_many([model] * 3).tip, str(analysis["analysis"])

def inner(count):
    with multiprocessing.get_context("fork").Pool(1) as pool:
        return pool.map_async(work, [0]).get(60) if count else [work(0)]

due = work(0)
with multiprocessing.get_context("fork").Pool(2) as pool:
    found = pool.map_async(work, range(4)).get(60)
    assert all(numpy.array_equal(own, of) for one in found for own, of in zip(one, due))
# A child of a child.
child = multiprocessing.get_context("fork").Process(target=inner, args=(1,))
child.start()
child.join(60)
assert child.exitcode == 0, child.exitcode
print("the same")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_forked_child_gives_the_numbers_of_its_parent(scenario):
    experiment = ROOT / "scenarios" / "diagnosis" / "nothing" / "experiment.toml"
    command = [sys.executable, "-c", FORKED, str(scenario), str(experiment)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=200)
    assert ran.stdout == "the same\n", ran.stderr
