"""Samples and sites, taken and decoded once in a process, for all the estimators in it."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Protocol

from rclpy.node import Node

from tissue_probe.nodes.cdr import samples_from_cdr
from tissue_probe.nodes.conversions import site_from_message
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.qos import ANNOUNCEMENTS, SAMPLE_BLOCKS
from tissue_probe.signals import PalpationSite, SampleBlock
from tissue_probe_msgs import msg

SITES = "palpation_site"
#: How long the stream waits before it looks whether it is to end [s].
END_LOOK_INTERVAL = 0.1


class Listener(Protocol):
    """Who takes samples and sites; called from the stream's thread."""

    def on_site(self, site: PalpationSite) -> None:
        """Take an announcement; it comes before the samples that it is for."""

    def on_samples(self, block: SampleBlock, frame_id: str) -> None:
        """Take the next samples."""


class SampleStream:
    """Hands samples and sites to its listeners as they come, in a thread of its own.

    A message that is malformed is left out, logged and counted.

    Parameters
    ----------
    owner : Node
        Whose names the topics are relative to.
    listeners : sequence of Listener
        In the order in which they are served.

    Attributes
    ----------
    malformed : int
        Messages that were left out.
    failure : Exception or None
        The error that ended the stream, if any; for the main thread to raise.
    """

    def __init__(self, owner: Node, listeners: Sequence[Listener]) -> None:
        self._owner = owner
        self._listeners = listeners
        self.malformed = 0
        self.failure: Exception | None = None
        self._inbox = Inbox(owner)
        self._inbox.subscribe(msg.PalpationSite, SITES, ANNOUNCEMENTS, self._on_site)
        self._inbox.subscribe(
            msg.ProbeSamples, "samples", SAMPLE_BLOCKS, self._on_samples, raw=True
        )
        self._stopping = threading.Event()
        # A daemon: if it hangs, the process still ends.
        self._thread = threading.Thread(target=self._run, name="estimation", daemon=True)
        self._thread.start()

    def publishers(self) -> int:
        """Return how many publishers of samples and sites are heard."""
        return self._inbox.publishers()

    def end(self) -> None:
        """End the thread and let go of the subscriptions; once is enough."""
        if not self._stopping.is_set():
            self._stopping.set()
            self._thread.join(10 * END_LOOK_INTERVAL)
            self._inbox.destroy()

    def _run(self) -> None:
        """Take messages as they come, without an executor's expense."""
        try:
            while not self._stopping.is_set():
                self._inbox.wait(END_LOOK_INTERVAL)
                self._inbox.empty()
        except Exception as error:  # told by the main thread, which ends the process
            if self._owner.context.ok():
                self.failure = error

    def _on_site(self, message: msg.PalpationSite, info: dict[str, int]) -> None:
        try:
            site = site_from_message(message)
        except ValueError as error:
            self._leave_out("an announcement of a site", error)
            return
        for listener in self._listeners:
            listener.on_site(site)

    def _on_samples(self, message: bytes, info: dict[str, int]) -> None:
        # A restart must be known before the samples that it is for, however many wait here.
        self._inbox.empty(SITES)
        try:
            block, frame_id = samples_from_cdr(message)
        except ValueError as error:
            self._leave_out("a block", error)
            return
        for listener in self._listeners:
            listener.on_samples(block, frame_id)

    def _leave_out(self, what: str, why: ValueError) -> None:
        self.malformed += 1
        self._owner.get_logger().error(f"{what} is left out: {why}", throttle_duration_sec=1.0)
