"""Reads RUN.mat by h5py, RUN5.mat by scipy and RUN.mcap by the reader of MCAP, and holds all against the run's own CSV."""

import csv
import json
import sys

import h5py
import scipy
import scipy.io
from mcap.reader import make_reader

run = sys.argv[1]
with open(f"{run}/trajectory.csv", newline="") as file:
    rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]
nodes = sum(name.startswith("x_") for name in rows[0])

with h5py.File(f"{run}.mat") as mat:
    trajectory = mat["trajectory"]
    for name in ["time_s", "tip_x_m", "tip_z_m", "total_J"]:
        assert list(trajectory[name][0]) == [row[name] for row in rows], name
    # HDF5 has the transpose of what MATLAB shows: nodes by samples.
    assert trajectory["z_m"].shape == (nodes, len(rows))
    assert list(trajectory["z_m"][nodes - 1]) == [row[f"z_{nodes - 1}_m"] for row in rows]
    text = lambda path: bytes(mat[path][:].astype("<u2")).decode("utf-16-le")
    assert text("unit/trajectory/tip_vx_m_s") == "m/s"
    assert json.loads(text("about/summary_json"))["samples"] == len(rows)
    print(f"h5py {h5py.__version__}: {len(trajectory)} columns of {len(rows)} samples")

mat = scipy.io.loadmat(f"{run}5.mat", simplify_cells=True)
for name in ["time_s", "tip_x_m", "tip_z_m", "total_J"]:
    assert list(mat["trajectory"][name]) == [row[name] for row in rows], name
assert mat["trajectory"]["z_m"].shape == (len(rows), nodes)
assert list(mat["trajectory"]["z_m"][:, nodes - 1]) == [row[f"z_{nodes - 1}_m"] for row in rows]
assert mat["unit"]["trajectory"]["tip_vx_m_s"] == "m/s"
assert json.loads(mat["about"]["summary_json"])["samples"] == len(rows)
print(f"scipy {scipy.__version__}: {len(mat['trajectory'])} columns of {len(rows)} samples")

with open(f"{run}.mcap", "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    tip = []
    for schema, channel, message in reader.iter_messages(topics=["/trajectory/tip"]):
        said = json.loads(message.data)
        assert set(said) == set(json.loads(schema.data)["properties"]), "the schema describes what is there"
        assert message.log_time == round(1e9 * said["time_s"])
        tip.append(said["tip_z_m"])
    assert tip == [row["tip_z_m"] for row in rows]
    topics = sorted(channel.topic for channel in reader.get_summary().channels.values())
    assert topics == [f"/trajectory/{body}" for body in ["body", "energy", "nodes", "tip"]], topics
    assert {own.name for own in reader.iter_attachments()} == {"summary.json", "scenario.resolved.toml"}
    print(f"mcap: {len(topics)} channels, {len(tip)} messages of the tip")
