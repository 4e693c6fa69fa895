"""The rows of a study in SQL, while it runs: python with_duckdb.py answers/rows specimens.csv."""

import sys

import duckdb

folder, output = sys.argv[1:]
rows = duckdb.read_parquet(f"{folder}/rows-*.parquet", union_by_name=True)
found = rows.query(
    "rows",
    "SELECT specimen, count(*) AS count, avg(stiffness) AS mean, stddev(stiffness) AS std "
    "FROM rows WHERE status = 'done' GROUP BY specimen ORDER BY specimen",
)
found.write_csv(output)
