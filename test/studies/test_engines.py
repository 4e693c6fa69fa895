"""A study runs on a real cluster, and a worker that is killed costs no recording."""

from __future__ import annotations

import os
import signal
import warnings

import joblib
import pytest
from laboratory import QUESTION
from test_study import plan_of

import tissue_probe as tp

distributed = pytest.importorskip("distributed")


@pytest.fixture
def cluster(tmp_path, monkeypatch):
    """Two workers, each a process of its own, on this machine."""
    monkeypatch.chdir(tmp_path)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as found,
        distributed.Client(found) as client,
    ):
        yield client


@pytest.mark.slow
def test_a_cluster_computes_the_rows_though_a_worker_is_killed(cluster, laboratory):
    pids = cluster.run(os.getpid)

    def kill(done: int, of: int) -> None:
        if done == 1:
            os.kill(next(iter(pids.values())), signal.SIGKILL)

    with warnings.catch_warnings(), joblib.parallel_config(backend="dask"):
        warnings.simplefilter("ignore")
        found = tp.study(plan_of(laboratory), progress=kill)
    assert "6 done" in found.text
    assert len({row["path"] for row in found.rows}) == 6


def test_a_row_is_a_function_for_any_engine(laboratory):
    paths = sorted(laboratory.glob("*.csv"))[:2]
    rows = joblib.Parallel(n_jobs=2)(
        joblib.delayed(tp.row)(path, "compare", **QUESTION) for path in paths
    )
    assert [row["status"] for row in rows] == ["done", "done"]
