"""``python -m tissue_probe``: the command line."""

from tissue_probe.cli import main

main()
