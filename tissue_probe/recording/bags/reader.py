"""Reading back the recording of a run.

Contents: which messages of a bag make up a recording, its estimates, its map.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator
from pathlib import Path

from tissue_probe.recording.bags import decoding
from tissue_probe.recording.bags.bag import Bag, RawMessage, Topic, by_log_time
from tissue_probe.recording.bags.decoding import Decoder, RecordedMap
from tissue_probe.recording.bags.open_bag import open_bag
from tissue_probe.recording.columns.source import Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import (
    EstimatorModel,
    PalpationSite,
    Recording,
    TissueEstimates,
    join,
)


def read_recording(path: str | Path, samples_topic: str | None = None) -> Recording:
    """Read the samples, the sites, the filters' models and the metadata of a run.

    Parameters
    ----------
    path : path
        An MCAP file, also one cut off (everything before the cut is read, and a warning
        logged), a ``.db3`` file or a bag folder.
    samples_topic : str, optional
        The topic of the samples; needed only where several have that type.

    Raises
    ------
    RecordingError
        If it is no such bag, has no samples, or several topics of samples and none chosen.
    """
    return recording_of(open_bag(path), path, samples_topic)


def recording_of(
    bag: Bag,
    path: str | Path,
    samples_topic: str | None = None,
    progress: Progress = lambda share: None,
) -> Recording:
    """Read an open bag as ``read_recording`` does; ``path`` is its name in messages.

    ``progress`` is told the share of the samples that is read, from 0 to 1.
    """
    topic = _samples_topic(bag, path, samples_topic)
    messages = by_log_time(bag, [topic.name], progress)
    blocks = join(Decoder(topic, path).decode_sound(messages, decoding.samples))
    if not blocks:
        raise RecordingError(f"{path} has no samples: nothing was published on {topic.name}")
    models = tuple(_models(bag, path, topic))
    return Recording(tuple(blocks), tuple(_sites(bag, path, topic)), bag.metadata, models=models)


def has_samples(bag: Bag) -> bool:
    """Return whether a bag is a recording of this suite: whether it has a topic of samples."""
    return bool(topics_of_type(bag, decoding.SAMPLES))


def read_estimates(path: str | Path) -> dict[str, TissueEstimates]:
    """Read the recorded estimates by the name of their estimator, one row a message.

    Live estimates come once a block of samples, not once a sample.

    Raises
    ------
    RecordingError
        If it is no bag that can be read, or estimates of one name come from two topics.
    """
    bag = open_bag(path)
    read: dict[str, TissueEstimates] = {}
    for topic in topics_of_type(bag, decoding.ESTIMATE):
        for name, found in _estimates(bag, path, topic).items():
            if name in read:
                raise RecordingError(
                    f"{path} has estimates of '{name}' on two topics, one of them {topic.name}; "
                    "record each probe to its own file"
                )
            read[name] = found
    return read


def read_map(path: str | Path) -> RecordedMap | None:
    """Read the last stiffness map that was recorded; None if there is none.

    Raises
    ------
    RecordingError
        If it is no bag that can be read.
    """
    bag = open_bag(path)
    topics = {topic.name: topic for topic in topics_of_type(bag, decoding.MAP_MESSAGE)}
    last = deque(by_log_time(bag, topics), maxlen=1)
    if not last:
        return None
    decoder = Decoder(topics[last[0].topic], path)
    return next(decoder.decode(last, decoding.stiffness_map))


def iterate_raw(path: str | Path, topics: Collection[str]) -> Iterator[RawMessage]:
    """Yield the messages of the topics as recorded, in the order of their log times.

    A file cut off ends where it was cut.

    Raises
    ------
    RecordingError
        If it is no bag that can be read, or a topic is not in it as CDR; before the first
        message is taken.
    """
    bag = open_bag(path)
    recorded = {topic.name for topic in bag.topics if topic.message_encoding == "cdr"}
    if missing := set(topics) - recorded:
        raise RecordingError(
            f"{path} has no CDR messages on {', '.join(sorted(missing))}; "
            f"it has {', '.join(sorted(recorded)) or 'none'}"
        )
    return by_log_time(bag, topics)


def topics_of_type(bag: Bag, typename: str) -> list[Topic]:
    """Return the bag's topics of a type, each name once."""
    return list({topic.name: topic for topic in bag.topics if topic.typename == typename}.values())


def _samples_topic(bag: Bag, path: str | Path, chosen: str | None) -> Topic:
    candidates = topics_of_type(bag, decoding.SAMPLES)
    names = ", ".join(topic.name for topic in candidates)
    if not candidates:
        recorded = ", ".join(f"{topic.name} ({topic.typename})" for topic in bag.topics)
        raise RecordingError(
            f"{path} (profile '{bag.profile}') has no topic of type {decoding.SAMPLES}; "
            f"it has {recorded or 'no topics'}"
        )
    if chosen is not None:
        candidates = [topic for topic in candidates if topic.name == chosen]
        if not candidates:
            raise RecordingError(f"{path} has no samples on {chosen}; it has them on {names}")
    if len(candidates) > 1:
        raise RecordingError(f"{path} has samples on several topics, choose one: {names}")
    return candidates[0]


def _sites(bag: Bag, path: object, samples: Topic) -> Iterator[PalpationSite]:
    topics = topics_of_type(bag, decoding.SITE)
    of_this_probe = [topic for topic in topics if _namespace(topic) == _namespace(samples)]
    for topic in of_this_probe or topics:
        yield from Decoder(topic, path).decode_sound(by_log_time(bag, [topic.name]), decoding.site)


def _models(bag: Bag, path: object, samples: Topic) -> Iterator[EstimatorModel]:
    """Yield by which models the estimators beside these samples ran."""
    topics = topics_of_type(bag, decoding.ESTIMATOR_MODEL)
    of_this_probe = [t for t in topics if t.name.rsplit("/", 2)[0] == _namespace(samples)]
    for topic in of_this_probe or topics:
        messages = by_log_time(bag, [topic.name])
        yield from Decoder(topic, path).decode_sound(messages, decoding.estimator_model)


def _namespace(topic: Topic) -> str:
    return topic.name.rpartition("/")[0]


def _estimates(bag: Bag, path: object, topic: Topic) -> dict[str, TissueEstimates]:
    rows: dict[str, list[decoding.EstimateRow]] = {}
    messages = by_log_time(bag, [topic.name])
    for row in Decoder(topic, path).decode_sound(messages, decoding.estimate_row):
        rows.setdefault(row[0], []).append(row)
    return {name: decoding.estimates(found) for name, found in rows.items()}
