"""The package tissue_probe, for pip and for ROS 2.

One file serves both, since each runs it with commands of its own:

- pip (by pyproject.toml) makes a wheel of it: `bdist_wheel`. That has one executable,
  `tissue_probe`, and knows nothing of ROS.
- colcon, as it does with every ament_python package, runs `install` or `develop`. Then each node is
  an executable, too, for `ros2 run tissue_probe NAME`; setup.cfg puts them all into
  `lib/tissue_probe`, where `ros2 run` looks and nobody's PATH does. In its own folder, to which it
  links this file, there is no pyproject.toml: so all that colcon needs is said here.
"""

import os
import re
import shlex
import sys
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

ESTIMATORS = ["robust_ekf", "ekf", "ukf", "afekf", "afukf", "lock_in", "rls"]
NODES = [
    "adapter",
    "driver",
    "estimators",
    "identify",
    "mapper",
    "monitor",
    "recorder",
    "replay",
    "scan",
    "sensor",
    "stage",
]

VERSION = re.search(r'__version__ = "(.+)"', Path("tissue_probe/__init__.py").read_text())[1]
#: Commands by which pip makes a wheel, or tells its future content.
FOR_PIP = {"bdist_wheel", "dist_info", "editable_wheel"}

#: Packages of messages that are needed, and where this project has them. colcon looks no deeper
#: than this package, and a build that took CRTK's from here would hide the original's other
#: messages.
MESSAGES = {"tissue_probe_msgs": "msg_defs", "crtk_msgs": "crtk_msgs"}


def build_messages() -> None:
    """Say at the end of colcon's build how messages are built that are not found."""
    index = "share/ament_index/resource_index/packages"
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    here = Path(__file__).resolve().parent
    missing = [
        str(here / folder)
        for package, folder in MESSAGES.items()
        if not any(Path(prefix, index, package).exists() for prefix in filter(None, prefixes))
    ]
    if missing:
        # colcon shows a build's text on this stream.
        print("The nodes need messages that are not built yet. Build all, in the same folder, by\n"
              f"colcon build --base-paths . {shlex.join(missing)}", file=sys.stderr)  # fmt: skip


executables = ["tissue_probe = tissue_probe.cli:main"]
data_files = [
    ("share/tissue_probe/config", glob("config/*")),
    ("share/tissue_probe", ["CITATION.cff"]),
    # One click away in the workbench.
    ("share/tissue_probe/examples", glob("examples/*.csv") + glob("examples/*.mcap")),
]
if FOR_PIP.isdisjoint(sys.argv):
    executables += [f"{name} = tissue_probe.nodes.{name}:main" for name in NODES]
    executables += [f"{name} = tissue_probe.nodes.estimator:main" for name in ESTIMATORS]
    data_files += [
        ("share/ament_index/resource_index/packages", ["resource/tissue_probe"]),
        ("share/tissue_probe", ["package.xml"]),
        ("share/tissue_probe/launch", glob("launch/*.launch.py")),
    ]

setup(
    name="tissue_probe",
    version=VERSION,
    packages=find_packages(include=["tissue_probe", "tissue_probe.*"]),
    package_data={
        "tissue_probe": ["py.typed"],
        "tissue_probe.estimation": ["templates/*.py"],
        "tissue_probe.report": ["*.jinja", "*.js"],
        "tissue_probe.workbench": ["page/*", "page/vendor/*"],
    },
    data_files=data_files,
    zip_safe=False,
    python_requires=">=3.10",
    maintainer="tissue_probe maintainers",
    description="Stiffness and damping of soft tissue from a vibrating palpation probe",
    license="Apache-2.0",
    entry_points={"console_scripts": executables},
)
if not {"install", "develop"}.isdisjoint(sys.argv):
    build_messages()
