"""Rows by joblib, on this machine: python with_joblib.py 'data/*.csv' rows.csv."""

import sys
from glob import glob

import pandas as pd
from joblib import Parallel, delayed

import tissue_probe as tp

pattern, output = sys.argv[1:]
rows = Parallel(n_jobs=2)(
    delayed(tp.row)(path, "estimate", force_polarity="compression")
    for path in sorted(glob(pattern))
)
pd.DataFrame(rows).to_csv(output, index=False)
