"""DDS domains, dealt to the workers that test side by side."""

from __future__ import annotations

#: Domains whose ports all lie below those that Linux hands out at random (32768 and above): DDS
#: gives 250 ports to each, from 7400 on. Domain 0 is everybody's.
SAFE = range(1, 101)


def domains_of(worker: int, workers: int) -> range:
    """Return the domains that are one worker's own.

    Parameters
    ----------
    worker : int
        Which it is, from 0.
    workers : int
        How many there are. One that pytest-xdist starts in the place of a dead one has a higher
        number, and the dead one's neighbour's domains: each is locked while it is used.
    """
    return SAFE[worker % workers :: workers]
