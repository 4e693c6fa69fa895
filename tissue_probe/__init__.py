"""tissue_probe: stiffness and damping of soft tissue from a vibrating palpation probe."""

__version__ = "0.1.0"
