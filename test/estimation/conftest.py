"""The benchmarks' simulator, which shares no code with the package, is the tests' truth too."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
