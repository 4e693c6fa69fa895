"""The ROS 2 package tissue_probe; `ros2 run tissue_probe NAME` starts each executable below."""

from glob import glob

from setuptools import find_packages, setup

ESTIMATORS = ["robust_ekf", "ekf", "ukf", "afekf", "afukf", "lock_in", "rls"]
NODES = ["driver", "estimators", "mapper", "recorder", "replay", "scan", "stage"]

setup(
    name="tissue_probe",
    version="0.1.0",
    packages=find_packages(include=["tissue_probe", "tissue_probe.*"]),
    package_data={"tissue_probe": ["py.typed"], "tissue_probe.report": ["*.jinja"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/tissue_probe"]),
        ("share/tissue_probe", ["package.xml"]),
        ("share/tissue_probe/config", glob("config/*")),
        ("share/tissue_probe/launch", glob("launch/*.launch.py")),
    ],
    zip_safe=False,
    maintainer="tissue_probe maintainers",
    maintainer_email="maintainers@tissue-probe.example",
    description="Stiffness and damping of soft tissue from a vibrating palpation probe",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "tissue_probe = tissue_probe.cli:main",
            *(f"{name} = tissue_probe.nodes.{name}:main" for name in NODES),
            *(f"{name} = tissue_probe.nodes.estimator:main" for name in ESTIMATORS),
        ]
    },
)
