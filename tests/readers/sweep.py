"""Reads the shards of a sweep, and its table, by DuckDB and Polars as the guide says, and its units by PyArrow.

Six points in three shards, of which the last two cannot be simulated.
"""

import sys

import duckdb
import polars
import pyarrow.parquet

sweep = sys.argv[1]
question = f"""
    SELECT shard, count(*), count(frequency_hz), any_value(reason)
    FROM read_parquet('{sweep}/shard=*/part.parquet', hive_partitioning = true)
    GROUP BY shard ORDER BY shard
"""
rows = duckdb.sql(question).fetchall()
assert [(int(row[0]), *row[1:3]) for row in rows] == [(0, 2, 2), (1, 2, 2), (2, 2, 0)], rows
assert rows[0][3] is None and "pressure" in rows[2][3], rows

shards = polars.scan_parquet(f"{sweep}/shard=*/part.parquet", hive_partitioning=True)
table = polars.read_parquet(f"{sweep}/sweep.parquet")
assert shards.drop("shard").sort("point").collect().equals(table, null_equal=True)
assert table["point"].to_list() == list(range(6))
assert table["status"].to_list() == ["ok"] * 4 + ["failed"] * 2
assert table["frequency_hz"].null_count() == 2

schema = pyarrow.parquet.read_schema(f"{sweep}/sweep.parquet")
units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}
assert units["muscle_pressure_pa"] == "Pa" and units["effects_payload_mass_kg"] == "kg", units
assert units["lowest_z_m"] == "m" and units["status"] == "", units
print(f"DuckDB {duckdb.__version__} and Polars {polars.__version__}: {len(table)} points, shards and table alike")
