"""Rows by Dask, here or on a cluster: python with_dask.py 'data/*.csv' rows.csv."""

import sys
from glob import glob

import pandas as pd
from distributed import Client

import tissue_probe as tp


def main(pattern: str, output: str) -> None:
    """Write a row of each recording; Client("tcp://scheduler:8786") asks a cluster."""
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        rows = client.map(tp.row, sorted(glob(pattern)), force_polarity="compression")
        pd.DataFrame(client.gather(rows)).to_csv(output, index=False)


if __name__ == "__main__":
    main(*sys.argv[1:])
