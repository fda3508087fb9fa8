#!/usr/bin/env python3
"""Diagnoses recordings and drawn experiments, and prints a row of each: the tables of docs/src/validation/evidence.md.

Usage: tests/recordings/evidence.py [NAME…] [--from FOLDER] [--efam PROGRAM] [--out FOLDER]
       tests/recordings/evidence.py --sets FOLDER   every experiment below it; truth.csv, if it is there, says what is hidden
"""

import argparse
import csv
import importlib.machinery
import importlib.util
import json
import resource
import subprocess
import sys
from pathlib import Path

loader = importlib.machinery.SourceFileLoader("recordings", str(Path(__file__).with_name("run")))
recordings = importlib.util.module_from_spec(importlib.util.spec_from_loader("recordings", loader))
loader.exec_module(recordings)


def hanging(length: str, mass: str, stiffness: str) -> str:
    """A cable of other data than the short black one."""
    rod = recordings.CABLE
    for was, now in (("400 mm", length), ("420 g", mass), ("0.10 N m^2", stiffness)):
        rod = rod.replace(f'"{was}"', f'"{now}"')
    return rod


SHORT_STRIP = (
    recordings.STRIP.replace("215.9 mm", "165.1 mm")
    .replace("1.535 g", "1.174 g")
    .replace("6.5e-5", "9.6e-5")
    .replace("-30.5 mm", "-31 mm")
)
# Real recordings beside those of `run`: their files, the rod, and what else the experiment says.
MORE = {
    "orange_short": (["hanging_cable/orange_short.csv"], hanging("450 mm", "250 g", "0.0809 N m^2"), ""),
    "black_long": (["hanging_cable/black_long.csv"], hanging("600 mm", "600 g", "0.1179 N m^2"), ""),
    "short_strip": (["card_strip/short.csv"], SHORT_STRIP, recordings.FREE),
    "arm": (["pneumatic_arm/100mbar.csv"], "", ""),
    "trunk": (["trunk/manual_decay_300g_id00.csv"], "", ""),
}
recordings.EXPERIMENTS |= MORE
NAMES = ["gravity", "loads", "force", "cable", "orange_short", "black_long", "strip", "short_strip", "arm", "trunk"]
# Effects of one law: a catalogue without one of them still has it.
ONE_LAW = ["creep", "viscoelastic", "relaxation"]


def diagnosed(efam: Path, file: Path, more: list[str]) -> tuple[dict, float]:
    """What is printed, and the seconds of processor time that it took; an error as a text."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = ["--out", file.parent / f"{file.stem}.answer", "--overwrite"]
    command = [efam, "diagnose", file, "--json", "--quiet", *out, *more]
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if done.returncode != 0:
        return {"error": " ".join(done.stderr.split())[:200]}, seconds
    return json.loads(done.stdout)["diagnosis"], seconds


def row(own: dict) -> tuple[str, str]:
    """The names of an answer, and its figures."""
    if "error" in own:
        return "error", own["error"]
    first = own["rounds"][0]["candidates"][:1] if own.get("rounds") else []
    odds = f"log odds {first[0]['all'] or first[0]['features']:.1f} for {first[0]['name']}; " if first else ""
    values = [(p["name"], p["value"], p["interval_95"]) for e in own["effects"] for p in e["parameters"][:2]]
    values += [(c["parameter"], c["value"], c.get("interval_95")) for c in own["contradictions"][:1]]
    gap = [(g["before_mm"], g["after_mm"]) for g in own["gap"] if not g["held_out"]]
    misfit = [(sum(x * x for x in xs) / max(len(gap), 1)) ** 0.5 for xs in zip(*gap)] or (0, 0)
    names, members = [e["effect"] for e in own["effects"]], [m["effect"] for m in own["members"]]
    names += [f"stated {own['freed']}"] if own.get("freed") else []
    said = f"{own['verdict']}: {' + '.join(names)}" + (f" ({', '.join(members)})" if members else "")
    interval = lambda of: f" ({of[0]:.3g} to {of[1]:.3g})" if of else ""
    values = ", ".join(f"{name} {value:.3g}{interval(of)}" for name, value, of in values[:4])
    runs = f"; {own['runs']} runs" if "runs" in own else ""
    return said, f"{odds}{misfit[0]:.3f} to {misfit[1]:.3f} mm; {values}{runs}"


def sets(folder: Path) -> list[tuple[str, Path, list[str]]]:
    """Experiments below a folder: what is hidden, the file, and options."""
    truth = folder / "truth.csv"
    if not truth.is_file():
        files = sorted(file for file in folder.glob("*/*.toml") if file.stem in ("experiment", "set"))
        return [(file.parent.name, file, []) for file in files]
    found = []
    for own in csv.DictReader(truth.open()):
        without = own["hidden"].split("=")[0] if own["robbed"] == "true" else ""
        excluded = (ONE_LAW if without in ONE_LAW else [without]) if without else []
        options = [word for name in excluded for word in ("--without", name)]
        name = f"{own['seed']} {own['hidden'] or 'nothing'}" + (" robbed" if without else "")
        found.append((name, folder / own["experiment"], options))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--from", dest="folder", type=Path, default=recordings.ROOT / "../shared/recordings")
    parser.add_argument("--efam", type=Path, default=recordings.ROOT / "target/release/efam")
    parser.add_argument("--out", type=Path, default=recordings.ROOT / "target/recordings")
    parser.add_argument("--sets", type=Path)
    options = parser.parse_args()
    if options.sets:
        asked = [own for own in sets(options.sets) if not options.names or any(n in own[0] for n in options.names)]
    else:
        asked = []
        for name in options.names or NAMES:
            file = recordings.experiment(options.efam, options.folder, name, options.out)
            asked.append((name, file, []))
    for name, file, more in asked:
        found, seconds = diagnosed(options.efam, file, more)
        said, figures = row(found)
        print(f"{name:36} {seconds:6.1f} s  {said}\n{'':38}{figures}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
