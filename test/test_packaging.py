"""The package as it is handed on: sdist, wheel in an environment of its own, ROS workspace."""

from __future__ import annotations

import email
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import venv
from pathlib import Path

import pytest
import yaml

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


def made(done: subprocess.CompletedProcess[str]) -> str:
    """Return what a command said that has to succeed."""
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def tracked() -> list[str]:
    return list(filter(None, run("git", "ls-files", "-z", cwd=ROOT).stdout.split("\0")))


def copied(folder: Path) -> None:
    """Copy the repository: a build must neither see nor leave anything beside the sources."""
    for name in tracked():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes((ROOT / name).read_bytes())


@pytest.fixture(scope="module")
def environment(tmp_path_factory) -> Path:
    """An environment with the wheel alone, which borrows the other packages: no network.

    The wheel is made from the sdist, which lies beside it. Borrowed packages lie behind its own,
    and those of ROS are hidden.
    """
    folder = tmp_path_factory.mktemp("wheel")
    copied(folder / "source")
    packed = "from setuptools import build_meta; build_meta.build_sdist('..')"
    made(run(sys.executable, "-c", packed, cwd=folder / "source"))
    (sdist,) = folder.glob("*.tar.gz")
    pip = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")
    made(run(*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", folder, sdist, cwd=folder))
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "venv", with_pip=False, symlinks=True)
    python = folder / "venv/bin/python"
    made(run(*pip, "--python", python, "install", "--no-deps", wheel, cwd=folder))
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


@pytest.mark.slow
def test_the_sdist_holds_all_that_is_tracked_but_what_serves_the_repository(environment):
    (sdist,) = environment.parent.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    assert {name for name in tracked() if not name.startswith(".")} <= held
    assert {"docs/python.md", "test/conftest.py", "msg_defs/package.xml"} <= held
    assert not any(name.endswith(".pyc") for name in held)


@pytest.mark.slow
def test_the_wheel_tells_indexes_and_citations_what_it_is(environment):
    (metadata,) = environment.glob("lib/python*/site-packages/tissue_probe-*.dist-info/METADATA")
    told = email.message_from_string(metadata.read_text())
    assert "palpation" in told["Keywords"]
    assert "Intended Audience :: Science/Research" in told.get_all("Classifier")
    citation = yaml.safe_load((environment / "share/tissue_probe/CITATION.cff").read_text())
    assert citation["version"] == told["Version"]
    assert citation["keywords"] == [each.strip() for each in told["Keywords"].split(",")]
    # There is no record of it elsewhere: nothing may point there.
    for text in (told.as_string().partition("\n\n")[0], str(citation)):
        assert not re.search(r"doi|https?://|@", text, re.I)


def test_the_version_stands_in_one_place():
    assert f"<version>{tissue_probe.__version__}</version>" in (ROOT / "package.xml").read_text()
    for name in ("setup.py", "pyproject.toml"):
        assert tissue_probe.__version__ not in (ROOT / name).read_text()


@pytest.fixture(scope="module")
def workspace(tmp_path_factory) -> Path:
    """A ROS workspace with a clone of this project among its sources."""
    folder = tmp_path_factory.mktemp("ws")
    copied(folder / "src/tissue_probe")
    return folder


def colcon(workspace: Path, *words: object, **variables: str) -> str:
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    command = (sys.executable, "-m", "colcon", *words)
    return made(run(*command, cwd=workspace, PATH=path, **variables))


def told_command(said: str) -> list[str]:
    """Return the words of the command that a build names at its end; none if it names none."""
    found = re.search(r"^colcon (build --base-paths .*)$", said, re.M)
    return shlex.split(found[1]) if found else []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("found", "built"),
    [
        ((), {"tissue_probe", "tissue_probe_msgs", "crtk_msgs"}),
        # A crtk_msgs of somebody else's has messages that ours lacks.
        (("crtk_msgs",), {"tissue_probe", "tissue_probe_msgs"}),
    ],
    ids=len,
)
def test_a_plain_build_names_the_command_that_builds_the_messages_too(
    workspace, tmp_path, found, built
):
    index = tmp_path / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    for package in found:
        (index / package).touch()
    assert colcon(workspace, "list", "--names-only").split() == ["tissue_probe"]
    told = told_command(colcon(workspace, "build", AMENT_PREFIX_PATH=str(tmp_path)))
    assert set(colcon(workspace, "list", "--names-only", *told[1:]).split()) == built


@pytest.mark.battery
@pytest.mark.timeout(1200)  # a compiler is busy for minutes
def test_the_command_that_a_plain_build_names_builds_the_messages(workspace, tmp_path):
    ros = tmp_path / "ros"
    mirrored(Path(sys.prefix), ros)
    around = {"AMENT_PREFIX_PATH": str(ros), "CMAKE_PREFIX_PATH": str(ros)}
    colcon(workspace, *told_command(colcon(workspace, "build", **around)), **around)
    asked = (
        "import crtk_msgs.msg, tissue_probe_msgs.msg, tissue_probe_msgs.action;"
        "print(crtk_msgs.__file__, tissue_probe_msgs.__file__)"
    )
    said = made(run("bash", "-c", f". install/setup.bash; {sys.executable} -c '{asked}'",
                    cwd=workspace))  # fmt: skip
    assert said.count(str(workspace / "install")) == 2
    index = workspace / "install/crtk_msgs", workspace / "install/tissue_probe_msgs"
    assert not told_command(colcon(workspace, "build", AMENT_PREFIX_PATH=":".join(map(str, index))))


def mirrored(prefix: Path, copy: Path) -> None:
    """Make of an install of ROS one that has no package of this project: by links."""
    own = {"tissue_probe", "tissue_probe_msgs", "crtk_msgs"}
    copy.mkdir()
    for each in prefix.iterdir():
        # Below the index lies a folder for each kind of resource, with a file for each package.
        within = each.name in ("share", "ament_index", "resource_index")
        if within or prefix.name == "resource_index":
            mirrored(each, copy / each.name)
        elif each.name not in own:
            (copy / each.name).symlink_to(each)
