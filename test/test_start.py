"""What is imported at the start: a program that only helps or refuses loads nothing that fits."""

from __future__ import annotations

import subprocess
import sys

import pytest

#: Each takes a noticeable part of a second, or seconds.
HEAVY = {
    "h5py", "llvmlite", "matplotlib", "nidaqmx", "numba", "pandas", "plotly", "pyarrow", "rclpy",
    "rosbags", "scipy", "starlette", "sympy", "uvicorn",
}  # fmt: skip
RUN = """
import sys
sys.argv = ["tissue_probe", *{arguments!r}]
try:
    from tissue_probe.cli import main
    main()
except SystemExit as ended:
    print(ended.code, file=sys.stderr)
print("MODULES", *sorted(sys.modules))
"""


def modules_of(code: str, folder) -> tuple[set[str], str]:
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True
    )
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("MODULES"))
    return set(line.split()[1:]), done.stderr


def test_the_package_alone_imports_nothing_but_of_the_standard_library(tmp_path):
    bare, _ = modules_of("import sys; print('MODULES', *sys.modules)", tmp_path)
    found, _ = modules_of("import sys, tissue_probe; print('MODULES', *sys.modules)", tmp_path)
    others = {name.partition(".")[0] for name in found - bare} - sys.stdlib_module_names
    assert others == {"tissue_probe"}


def test_what_is_known_of_rigs_and_tissues_takes_no_numbers_and_no_symbols(tmp_path):
    code = (
        "import sys; from tissue_probe.physics import kinds, rigs; print('MODULES', *sys.modules)"
    )
    found, _ = modules_of(code, tmp_path)
    assert not found & (HEAVY | {"numpy", "pydantic", "rich"})


def test_help_imports_neither_numbers_nor_settings(tmp_path):
    found, _ = modules_of(RUN.format(arguments=["--help"]), tmp_path)
    assert not found & (HEAVY | {"numpy", "pydantic", "rich"})


@pytest.mark.parametrize("command", ["compare", "diagnose", "improve"])
def test_a_file_that_is_not_there_is_refused_before_anything_that_reads_it(command, tmp_path):
    found, told = modules_of(RUN.format(arguments=[command, "none.csv"]), tmp_path)
    assert "none.csv: No such file or directory" in told
    assert not found & (HEAVY | {"numpy"})


def test_a_file_that_cannot_be_read_is_refused_before_anything_that_fits(tmp_path):
    (tmp_path / "words.csv").write_text("no,numbers\n")
    found, told = modules_of(RUN.format(arguments=["compare", "words.csv"]), tmp_path)
    assert "words.csv has" in told
    assert not found & HEAVY


def test_a_model_on_disk_is_compared_without_symbols_or_a_compiler(tmp_path):
    made = [
        "challenge", "make", "--count", "1", "--hide", "none", "--excitation", "sine10", "made",
    ]  # fmt: skip
    modules_of(RUN.format(arguments=made), tmp_path)
    compare = RUN.format(
        arguments=["compare", "made/0001.csv", "--rig", "compliant_probe", "--starts", "at-rest"]
    )
    modules_of(compare, tmp_path)  # compiles, where no earlier process has
    found, _ = modules_of(compare, tmp_path)
    assert not found & {"sympy", "numba", "scipy.stats", "scipy.signal", "scipy.optimize"}
    assert (tmp_path / "compare.png").exists()
