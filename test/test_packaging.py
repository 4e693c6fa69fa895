"""A wheel of the package, in an environment of its own: one executable, and nothing of ROS."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

import tissue_probe

ROOT = Path(__file__).parents[1]
BLOCK = """
import sys
class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {hidden!r}:
            raise ModuleNotFoundError("no module named " + name, name=name)
sys.meta_path.insert(0, Hidden())
"""


def run(*command: object, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "AMENT_PREFIX_PATH")}
    return subprocess.run(
        list(map(str, command)), cwd=cwd, env=kept | variables, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def environment(tmp_path_factory) -> Path:
    """An environment with the wheel alone, which borrows the other packages: no network.

    Borrowed packages lie behind its own, and those of ROS are hidden.
    """
    folder = tmp_path_factory.mktemp("wheel")
    # A copy: the build must neither see nor leave anything beside the sources.
    source = folder / "source"
    tracked = run("git", "ls-files", "-z", cwd=ROOT).stdout.split("\0")
    for name in filter(None, tracked):
        if name.startswith(("tissue_probe/", "requirements/", "config/")) or "/" not in name:
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    pip = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")
    built = run(*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", folder, source,
                cwd=folder)  # fmt: skip
    assert built.returncode == 0, built.stderr
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "venv", with_pip=False, symlinks=True)
    python = folder / "venv/bin/python"
    installed = run(*pip, "--python", python, "install", "--no-deps", wheel, cwd=folder)
    assert installed.returncode == 0, installed.stderr
    (site,) = (folder / "venv/lib").glob("python*/site-packages")
    (site / "hide_ros.py").write_text(BLOCK.format(hidden=("rclpy", "tissue_probe_msgs")))
    (site / "borrowed.pth").write_text(f"import hide_ros\n{sysconfig.get_path('purelib')}\n")
    return folder / "venv"


@pytest.mark.slow
def test_one_executable_is_installed(environment):
    others = ("activate", "Activate", "python", "pip")
    names = [path.name for path in (environment / "bin").iterdir()]
    assert [name for name in names if not name.startswith(others)] == ["tissue_probe"]


@pytest.mark.slow
def test_the_program_compares_a_recording_without_ros(environment, tmp_path):
    program = environment / "bin/tissue_probe"
    told = run(program, "--help", cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    assert "diagnose" in told.stdout
    recording = ROOT / "examples/sweep.csv"
    stated = ("--rig", "compliant_probe", "--force-polarity", "compression", "--starts", "at-rest")
    compared = run(program, "compare", recording, *stated, cwd=tmp_path)
    assert compared.returncode == 0, compared.stderr
    stiffness = float(re.search(r"^  stiffness +([\d.]+)", compared.stdout, re.M)[1])
    assert stiffness > 0
    assert (tmp_path / "compare.png").stat().st_size > 0


@pytest.mark.slow
def test_the_stock_configuration_is_in_the_wheel(environment, tmp_path):
    asked = (
        "from tissue_probe.configuration import stock_configuration as s; import sys;"
        "import tissue_probe; print(s('phantom.yaml')); print(tissue_probe.__file__);"
        "print('rclpy' in sys.modules)"
    )
    told = run(environment / "bin/python", "-c", asked, cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    phantom, package, ros = told.stdout.splitlines()
    assert Path(phantom).is_relative_to(environment)
    assert Path(package).is_relative_to(environment)
    assert ros == "False"


def test_the_version_stands_in_one_place():
    assert f"<version>{tissue_probe.__version__}</version>" in (ROOT / "package.xml").read_text()
    for name in ("setup.py", "pyproject.toml"):
        assert tissue_probe.__version__ not in (ROOT / name).read_text()
