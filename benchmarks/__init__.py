"""How fast and how well the suite does its work, measured on this machine: `make benchmark`."""
