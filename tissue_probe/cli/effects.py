"""``tissue_probe effects``: which effects a model may miss, and the meaning of each."""

from __future__ import annotations


def effects() -> None:
    """List the effects that a model may miss, and their meaning.

    A line each, under the family that it belongs to.
    """
    from tissue_probe.physics.library import effects as library

    found = library()
    width = max(map(len, found))
    family = ""
    for each in found.values():
        if each.family != family:
            family = each.family
            print(f"{family}:")
        asked = "" if each.odds else f" (tried only with --prior {each.name}=1 or --add)"
        print(f"  {each.name:{width}}  {each.physics}{asked}")
