"""Samples as a recording of the suite, written without ROS.

What belongs here: MCAP from samples that no node published. What does not: what nodes record
(``writer``, the recorder node), tables (``tables``).
"""

from __future__ import annotations

from pathlib import Path

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.recording.decoding import SAMPLES
from tissue_probe.recording.definitions import message_definition, share_folders
from tissue_probe.recording.writer import McapWriter
from tissue_probe.signals import NANOSECONDS, SampleBlock

TOPIC = "/probe/samples"
MESSAGE = 100
"""Samples in one message."""


def write_samples_bag(path: str | Path, block: SampleBlock) -> None:
    """Write samples to a new MCAP file, as ``ProbeSamples`` on ``/probe/samples``.

    Parameters
    ----------
    path : path
        The file to create.
    block : SampleBlock
        The samples.

    Raises
    ------
    FileExistsError
        If the file exists: a recording is never overwritten.
    FileNotFoundError
        If the suite's messages are not installed.
    OSError
        If the file cannot be written.
    """
    definition = message_definition(SAMPLES, share_folders())
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, SAMPLES))
    types = store.types
    with McapWriter(path, {}) as writer:
        channel = writer.add_topic(TOPIC, SAMPLES, definition, "")
        for first in range(0, len(block), MESSAGE):
            part = block[first : first + MESSAGE]
            time = types["builtin_interfaces/msg/Time"](*divmod(part.stamp, NANOSECONDS))
            message = types[SAMPLES](
                types["std_msgs/msg/Header"](time, "probe"),
                part.sequence,
                part.sample_period,
                part.position,
                part.force,
                part.command,
            )
            data = bytes(store.serialize_cdr(message, SAMPLES))
            writer.write(channel, part.stamp, part.stamp, data)
