"""The benchmark of bags counts what it says."""

from benchmarks import reading_bags


def test_every_combination_is_read_and_no_corruption_is_silent(tmp_path, monkeypatch):
    monkeypatch.setattr(reading_bags, "CORRUPTIONS", 30)
    assert reading_bags._conformance(tmp_path) == {"right": 416, "of": 416}
    counts = reading_bags._corruption(tmp_path)
    assert counts["told"] + counts["refused"] == 30
    silent = ("wrong_messages", "silently_missing", "metadata_silently_changed")
    assert [counts[name] for name in silent] == [0, 0, 0]


def test_a_reader_that_tells_nothing_is_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(reading_bags, "CORRUPTIONS", 30)
    monkeypatch.setattr("tissue_probe.recording.bags.mcap_bag._log.warning", lambda *_: None)
    assert reading_bags._corruption(tmp_path)["silently_missing"] > 0
