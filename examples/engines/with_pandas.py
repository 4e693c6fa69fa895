"""The table of a study in pandas: python with_pandas.py answers/table.parquet specimens.csv."""

import sys

import pandas as pd

table, output = sys.argv[1:]
rows = pd.read_parquet(table)
done = rows[rows["status"] == "done"]
found = done.groupby("specimen")["stiffness"].agg(["count", "mean", "std"])
found.to_csv(output)
