"""Kernels are generated once and found again by later processes."""

import sys

from tissue_probe.physics import code_cache


def test_generated_code_is_written_once_and_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("TISSUE_PROBE_CACHE", str(tmp_path))
    calls = []

    def write():
        calls.append(1)
        return "ANSWER = 42\n"

    assert code_cache.module("answer", write).ANSWER == 42
    assert code_cache.module("answer", write).ANSWER == 42
    (path,) = tmp_path.glob("tissue_probe_answer_*.py")
    del sys.modules[path.stem]
    assert code_cache.module("answer", write).ANSWER == 42
    assert calls == [1]


def test_code_that_fails_is_not_taken_for_imported(tmp_path, monkeypatch):
    monkeypatch.setenv("TISSUE_PROBE_CACHE", str(tmp_path))
    for _ in range(2):
        try:
            code_cache.module("broken", lambda: "1 / 0\n")
        except ZeroDivisionError:
            continue
        raise AssertionError("the module was taken for imported")


def test_a_folder_that_cannot_be_made_is_replaced_by_a_temporary_one(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("TISSUE_PROBE_CACHE", str(blocked / "cache"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert code_cache.module("elsewhere", lambda: "ANSWER = 43\n").ANSWER == 43
    assert list(tmp_path.glob("tissue_probe_*/tissue_probe_elsewhere_*.py"))
