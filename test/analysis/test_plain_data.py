"""Results are plain data: they come back from bytes equal, and a call gives the same anywhere."""

import copy
import gc
import multiprocessing
import os
import pickle
import threading
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import tissue_probe as tp
from tissue_probe.physics.model_file import UnnamedEffectError

TIME = np.arange(600) / 1000.0
STATED = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}


def table(seed=0, size=1.0, samples=600):
    time = np.arange(samples) / 1000.0
    depth = size * 1e-3 * (1.0 + np.sin(20 * np.pi * time))
    force = 450.0 * depth + 3.0 * np.gradient(depth, time)
    noise = np.random.default_rng(seed).normal(0.0, size * 2e-3, time.size)
    return {"t": time, "u": depth, "F": force + noise}


def read(*given, **stated):
    return tp.read(table(*given, **stated), force_polarity="compression")


def sites():
    x, y = (each.ravel() for each in np.meshgrid(np.arange(4) / 100.0, np.arange(4) / 100.0))
    return {"x": x, "y": y, "k": 450.0 + 9.0 * np.random.default_rng(1).standard_normal(x.size)}


def results():
    measured = read()
    compared = tp.compare(measured, **STATED)
    yield from (measured, compared, compared.view(), compared.model, compared.parameters)
    yield compared.plus("cubic_stiffening")
    yield tp.compare(read(size=1000.0), **STATED).plus("cubic_stiffening")
    yield from (tp.estimate(measured), tp.map(sites()), tp.effects(), tp.estimators())
    yield tp.diagnose(measured, add=["standard_linear_solid"], prior={"relaxation": 3.0}, **STATED)
    yield tp.promises(measured, **STATED)


def same(result):
    return result


@pytest.fixture(scope="module")
def every_result():
    return list(results())


@pytest.mark.parametrize("carried", [lambda r: pickle.loads(pickle.dumps(r)), copy.deepcopy])
def test_a_result_comes_back_equal_and_prints_the_same(every_result, carried):
    for result in every_result:
        found = carried(result)
        assert found == result
        assert str(found) == str(result)


def test_a_result_comes_back_from_another_process(every_result):
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        for result, found in zip(every_result, pool.map(same, every_result), strict=True):
            assert found == result
            assert str(found) == str(result)


def test_joblib_carries_results(every_result):
    joblib = pytest.importorskip("joblib")
    found = joblib.Parallel(1, backend="loky")(
        [joblib.delayed(same)(each) for each in every_result]
    )
    assert found == every_result


def test_a_result_of_other_samples_is_another():
    assert read() != read(1)
    assert tp.compare(read(), **STATED) != tp.compare(read(1), **STATED)


def test_errors_come_back_from_bytes(tmp_path):
    with pytest.raises(tp.TissueProbeError) as refused:
        tp.read(tmp_path / "none.csv")
    for error in (refused.value, UnnamedEffectError(tmp_path, "mine", "mine.py")):
        found = pickle.loads(pickle.dumps(error))
        assert type(found) is type(error)
        assert str(found) == str(error)


def numbers(seed):
    """The bits of an answer."""
    measured = read(seed)
    compared = tp.compare(measured, **STATED)
    estimated = tp.estimate(measured)
    bits = *compared.fit.values.tolist(), compared.rmse, estimated.stiffness, estimated.damping
    return tuple(float(each).hex() for each in bits), str(compared)


SEEDS = range(4)


@pytest.fixture(scope="module")
def alone():
    return [numbers(seed) for seed in SEEDS]


def test_a_call_gives_the_same_bits_in_eight_threads(alone):
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(numbers, [*SEEDS, *SEEDS, *SEEDS, *SEEDS]))
    assert found == alone * 4


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_call_gives_the_same_bits_in_other_processes(alone, method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system knows no {method}")
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        assert list(pool.map(numbers, SEEDS)) == alone


def test_one_worker_keeps_a_call_in_its_own_process(monkeypatch):
    fork, copies, answers = os.fork, [], []

    def counted():
        copies.append(fork())
        return copies[-1]

    monkeypatch.setattr(os, "fork", counted)
    # As in a program by itself: the thread of pytest-xdist waits, and holds no lock.
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    for workers in (2, 1):
        found = tp.diagnose(read(), workers=workers, **STATED)
        told = (
            found.verdict,
            str(found.ranking),
            str(tp.promises(read(), workers=workers, **STATED)),
        )
        answers.append((*told, str(tp.compare(read(), workers=workers, **STATED))))
        copies.append(workers)
    assert copies.index(2) > 0  # two of them do make copies
    assert copies[copies.index(2) + 1 :] == [1]
    assert answers[0] == answers[1]


def test_nothing_of_a_call_is_kept_when_its_result_has_gone():
    def call(seed):
        str(tp.compare(read(seed, samples=2000 + seed), **STATED))

    for seed in range(3):
        call(seed)
    gc.collect()
    tracemalloc.start()
    try:
        call(3)
        gc.collect()
        before, _ = tracemalloc.get_traced_memory()
        for seed in range(4, 24):
            call(seed)
        gc.collect()
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 20 * 5_000
