"""One record on disk as it comes: its samples and the driver's excitation, in an MCAP file."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path

import yaml

from tissue_probe.nodes.cdr import samples_to_cdr
from tissue_probe.nodes.log_time import LogTime
from tissue_probe.recording.bags.definitions import message_definition, share_folders
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.signals import SampleBlock

TYPE = "tissue_probe_msgs/msg/ProbeSamples"


class RecordFile:
    """Writes blocks of samples; what is written outlives this process.

    Parameters
    ----------
    path : path
        The file, which must not exist.
    topic : str
        Full name of the samples' topic.
    driver : str
        Full name of the driver.
    parameters : mapping
        Of the driver, by name: kept at the file's head.

    Raises
    ------
    OSError
        If the file cannot be written.
    """

    def __init__(
        self, path: Path, topic: str, driver: str, parameters: Mapping[str, object]
    ) -> None:
        told = {n: yaml.safe_dump(v).removesuffix("...\n").strip() for n, v in parameters.items()}
        self._writer = McapWriter(path, {driver: told})
        definition = message_definition(TYPE, share_folders())
        self._channel = self._writer.add_topic(topic, TYPE, definition, "")
        self._log_time = LogTime()

    def write(self, block: SampleBlock, frame_id: str) -> None:
        """Write the next samples.

        Raises
        ------
        OSError
            If they, or earlier ones, could not be stored.
        """
        self._log_time.look()
        received = self._log_time.of(time.time_ns())
        self._writer.write(self._channel, received, block.stamp, samples_to_cdr(block, frame_id))

    def close(self) -> None:
        """Close the file; once is enough."""
        self._writer.close()
