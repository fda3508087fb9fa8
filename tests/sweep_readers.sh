#!/usr/bin/env bash
# Whether DuckDB and Polars read a sweep's shards and its table as the README says.
#
# Goal: both find every row of every shard, the number of the shard, texts, and where a number is missing; the unit of a
# column stands in its metadata. Setup: six points in three shards, two of which cannot be simulated. Python and both
# packages go into a folder of their own; where these cannot be had it says so and passes.
#
#     tests/sweep_readers.sh target/debug/efam
set -euo pipefail

efam=$(realpath "${1:-target/debug/efam}")
scenario=$(realpath "$(dirname "$0")/../scenarios/release-15psi.toml")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT

python3 -m venv "$dir/python" >/dev/null 2>&1 &&
  "$dir/python/bin/pip" install --quiet duckdb polars pyarrow >/dev/null 2>&1 || {
  echo "-- skipped: Python with duckdb, polars and pyarrow cannot be had"
  exit 0
}
cat >"$dir/sweep.toml" <<TOML
[sweep]
scenario = "$scenario"
design = "grid"
[[sweep.parameter]]
path = "muscle.pressure"
values = ["15 psi", "40 psi", "400 psi"]
[[sweep.parameter]]
path = "effects.payload.mass"
values = ["0 g", "50 g"]
TOML
"$efam" -q sweep "$dir/sweep.toml" --points-per-shard 2 --out "$dir/map"
cd "$dir"
"$dir/python/bin/python" <<'PY'
import duckdb
import polars
import pyarrow.parquet

question = """
    SELECT shard, count(*), count(frequency_hz), any_value(reason)
    FROM read_parquet('map/shard=*/part.parquet', hive_partitioning = true)
    GROUP BY shard ORDER BY shard
"""
rows = duckdb.sql(question).fetchall()
assert [(int(row[0]), *row[1:3]) for row in rows] == [(0, 2, 2), (1, 2, 2), (2, 2, 0)], rows
assert rows[0][3] is None and "400" in rows[2][3] or "pressure" in rows[2][3], rows

shards = polars.scan_parquet("map/shard=*/part.parquet", hive_partitioning=True)
table = polars.read_parquet("map/sweep.parquet")
assert shards.drop("shard").sort("point").collect().equals(table, null_equal=True)
assert table["point"].to_list() == list(range(6))
assert table["status"].to_list() == ["ok"] * 4 + ["failed"] * 2
assert table["frequency_hz"].null_count() == 2

schema = pyarrow.parquet.read_schema("map/sweep.parquet")
units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}
assert units["muscle_pressure_pa"] == "Pa" and units["effects_payload_mass_kg"] == "kg", units
assert units["lowest_z_m"] == "m" and units["status"] == "", units
PY
echo "   DuckDB and Polars read shards and table alike"
