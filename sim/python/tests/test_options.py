"""Options: their types are those of the program's keys, and misspelt ones are found before and while it runs."""

import os
import subprocess
import sys

import efam
import pytest
from efam import _efam

from conftest import ROOT

FILE = ROOT / "sim" / "python" / "efam" / "_options.py"
HEAD = '''"""Options by their names, and keys of scenarios and experiments: for editors and mypy.

Generated from those that the program accepts; do not edit. To write it anew:

    EFAM_WRITE_DOCS=1 sim/python/check
"""

from typing import Any, SupportsFloat, TypedDict, Union

Quantity = Union[str, SupportsFloat]
'''


def written() -> str:
    keys, sections = _efam.option_keys()

    def entry(name, unit):
        comment = "" if unit is None else f"  # {unit or 'dimensionless'}"
        return f'        "{name}": {"Any" if unit is None else "Quantity"},{comment}\n'

    def table(name, entries):
        return f'\n{name} = TypedDict(\n    "{name}",\n    {{\n{"".join(entries)}    }},\n    total=False,\n)\n'

    options = table("Options", [entry(*own) for own in keys])
    return HEAD + options + table("ExperimentOptions", [entry(name, None) for name in sections])


def test_types_of_options_are_those_of_the_program():
    text = written()
    if os.environ.get("EFAM_WRITE_DOCS"):
        FILE.write_text(text)
    assert FILE.read_text() == text, "write it anew: EFAM_WRITE_DOCS=1 sim/python/check"


PLANTED = '''
import efam

model = efam.Model("a.toml", payload="20 g", angle=0.1, **{"effects.air_drag.drag_coefficient": 1.1})
efam.simulate(model.replace(**{"rod.nodes": 16}), duration=2)
efam.calibrate(efam.Experiment("b.toml", **{"calibrate.mesh": "kept"}), profile=True)
options: efam.Options = {"rod.nodes": 16, "muscle.pressure": "15 psi"}
efam.simulate(model, **options)

efam.Model("a.toml", paylod="20 g")
model.replace(presure="15 psi")
efam.simulate(model, durations=2)
efam.diagnose("b.toml", calibrat={})
wrong: efam.Options = {"effects.air_drag.drag_coeficient": 1.1}
model.start().set(payload=[1])
'''


def test_a_misspelt_option_is_an_error_of_mypy(tmp_path):
    pytest.importorskip("mypy")
    file = tmp_path / "planted.py"
    file.write_text(PLANTED)
    command = [sys.executable, "-m", "mypy", "--strict", str(file)]
    ran = subprocess.run(command, capture_output=True, text=True)
    found = [int(line.split(":")[1]) for line in ran.stdout.splitlines() if ": error:" in line]
    wrong = PLANTED[: PLANTED.index('efam.Model("a.toml", paylod')].count("\n") + 1
    assert found == list(range(wrong, wrong + 6)), ran.stdout


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        ("payloads", "payload"),
        ("paylod", "payload"),
        ("presure", "pressure"),
        ("durration", "duration"),
        ("payload.mass", "effects.payload.mass"),
    ],
)
def test_a_misspelt_option_offers_the_nearest(scenario, option, meant):
    with pytest.raises(efam.ScenarioError, match=f"did you mean `{meant}`"):
        efam.Model(scenario, **{option: "20 g"})
    with pytest.raises(efam.ScenarioError, match=f"did you mean `{meant}`"):
        efam.Model(scenario).replace(**{option: "20 g"})


def test_a_file_of_another_kind_names_the_call_that_takes_it(scenario):
    recording = scenario.parent / "diagnosis" / "nothing" / "15psi-1.csv"
    with pytest.raises(efam.ScenarioError, match="is a recording, .* efam.Experiment.init"):
        efam.analyse(recording)
    with pytest.raises(efam.ScenarioError, match="is a scenario, .* efam.simulate"):
        efam.analyse(scenario)
    with pytest.raises(efam.ScenarioError, match="is an experiment, .* efam.analyse"):
        efam.simulate(scenario.parent / "diagnosis" / "nothing" / "experiment.toml")
