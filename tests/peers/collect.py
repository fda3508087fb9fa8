"""Of all that was measured: results.csv, the table results.md, and the plot of error over cost.

`python collect.py FOLDER` reads the lines that measure.py printed, `FOLDER/*.jsonl`.
"""

import csv
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "peers", "svg.fonttype": "none"})
import matplotlib.pyplot as plt

from case import CASES, DURATION, HERE

ENOUGH_MM = 0.05
MARKS = {"efam": "o", "numba, LSODA": "s", "scipy, Radau": "D", "Exudyn": "^", "MuJoCo, chain": "v", "MuJoCo, cable": "<",
         "PyElastica": "P", "DiSMech-Newton": "X"}
ALIKE = {"efam": {"tol": 1e-4}, "numba, LSODA": {"tol": 1e-4}, "Exudyn": {"step": 2.5e-3}, "MuJoCo, chain": {"step": 1e-3},
         "DiSMech-Newton": {"step": 5e-3}}  # of the scaling with the mesh
TITLES = {"mass-damping": "α = 1 1/s", "both-dampings": "α = 1 1/s, β = 10 ms"}


def said(setting):
    words = {"nodes": "{} nodes", "elements": "{} elements", "tol": "tolerance {:g}", "step": "steps of {:g} s"}
    return ", ".join(words[key].format(value) for key, value in setting.items() if key in words)


def best(rows):
    """The cheapest that is good enough, or else the best there is."""
    good = [row for row in rows if row["error_mm"] <= ENOUGH_MM]
    return min(good, key=lambda row: row["cpu_s"]) if good else min(rows, key=lambda row: row["error_mm"])


def front(rows):
    """Those that no other beats in both, by cost."""
    kept = []
    for row in sorted(rows, key=lambda row: row["cpu_s"]):
        if not kept or row["error_mm"] < kept[-1]["error_mm"]:
            kept.append(row)
    return kept


def number(value, digits=2):
    return f"{float(f'{value:.{digits}g}'):g}"


def scaling(rows):
    """Processor time over the size of the mesh, everything else alike, as a table."""
    meshes = [16, 32, 64, 96, 128]
    text = "| package | " + " | ".join(map(str, meshes)) + " |\n|---" + "|---" * len(meshes) + "|\n"
    for case in CASES:
        for name, alike in ALIKE.items():
            cells = {row["setting"].get("nodes") or row["setting"]["elements"]: row["cpu_s"] for row in rows
                     if (row["case"], row["contestant"]) == (case, name) and alike.items() <= row["setting"].items()}
            if len(cells) > 2:
                cells = [number(cells[n]) if n in cells else "–" for n in meshes]
                text += f"| {name}, {said(alike)}, {TITLES[case]} | " + " | ".join(cells) + " |\n"
    return "\n**Processor time over nodes, of Exudyn over elements, s**\n\n" + text


def main(folder):
    rows = [json.loads(line) for file in sorted(Path(folder).glob("*.jsonl")) for line in file.read_text().splitlines()]
    rows = [row for row in rows if row["error_mm"] < 100]  # others went astray
    with open(HERE / "results.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["case", "contestant", "setting", "error_mm", "cpu_s", "wall_s", "memory_mb", "start_cpu_s"])
        for row in rows:
            out.writerow([row["case"], row["contestant"], said(row["setting"]), f"{row['error_mm']:.5f}",
                          f"{row['cpu_s']:.5f}", f"{row['wall_s']:.5f}", f"{row['memory_mb']:.0f}", f"{row['start_s']:.2f}"])
    text = ""
    figure, axes = plt.subplots(1, len(CASES), figsize=(9.5, 4.2), sharey=True, constrained_layout=True)
    for case, axis in zip(CASES, axes):
        own = {name: [row for row in rows if (row["case"], row["contestant"]) == (case, name)] for name in MARKS}
        own = {name: all_of for name, all_of in own.items() if all_of}
        ours = best(own["efam"])["cpu_s"]
        text += f"\n**{TITLES[case]}**\n\n"
        text += "| package | setting | error, mm | processor time, s | per simulated second, ms | times ours | memory, MB |\n"
        text += "|---|---|---|---|---|---|---|\n"
        for name, row in sorted(((name, best(all_of)) for name, all_of in own.items()), key=lambda of: of[1]["cpu_s"]):
            text += (f"| {name} | {said(row['setting'])} | {number(row['error_mm'])} | {number(row['cpu_s'])} | "
                     f"{number(1e3 * row['cpu_s'] / DURATION)} | {number(row['cpu_s'] / ours)} | {row['memory_mb']:.0f} |\n")
        for name, all_of in own.items():
            line, color = front(all_of), "black" if name == "efam" else f"C{list(MARKS).index(name) - 1}"
            axis.loglog([row["cpu_s"] for row in line], [row["error_mm"] for row in line], marker=MARKS[name],
                        markersize=5, linewidth=1, color=color, label=name)
        axis.axhline(ENOUGH_MM, color="grey", linewidth=0.8, linestyle=":")
        axis.set_title(TITLES[case], fontsize=10)
        axis.set_xlabel("processor time of 20 s, s")
        axis.grid(which="major", linewidth=0.3)
    axes[0].set_ylabel("distance of the tip from the converged path, rms, mm")
    axes[0].legend(fontsize=8, frameon=False)
    figure.savefig(HERE / "../../docs/src/pictures/peers.svg", metadata={"Date": None})
    figure.savefig(Path(folder) / "peers.png", dpi=110)
    text += scaling(rows)
    (HERE / "results.md").write_text(text.lstrip())
    print(text)


main(*sys.argv[1:])
