"""The specimen of the tests of diagnosis serves the reports, too."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "diagnosis"))
