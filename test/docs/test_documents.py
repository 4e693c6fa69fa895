"""What the documents name must exist: commands and options, links, targets, topics, parameters."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
import typer

from tissue_probe.cli import app
from tissue_probe.devices.limits import Limits
from tissue_probe.devices.registry import DEVICES
from tissue_probe.diagnosis.advice import visibility
from tissue_probe.diagnosis.evidence import adequacy, posterior
from tissue_probe.diagnosis.fitting import problem
from tissue_probe.diagnosis.improvement import ladder, moves, queue
from tissue_probe.diagnosis.ranking import harmonic, rules
from tissue_probe.diagnosis.revisions import loop
from tissue_probe.estimation import ESTIMATORS, EstimatorSettings
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.recording.robot.settings import RobotDescription

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
ALL_DOCUMENTS = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in (
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *sorted((ROOT / "docs").rglob("*.md")),
    )
}
DEPENDENCIES = ALL_DOCUMENTS["docs/dependencies.md"]
DIAGNOSIS = ALL_DOCUMENTS["docs/diagnosis.md"]
EVERYTHING = "\n".join(ALL_DOCUMENTS.values())
NODES = ROOT / "tissue_probe" / "nodes"
SOURCES = "\n".join(path.read_text(encoding="utf-8") for path in sorted(NODES.glob("*.py")))
PROGRAM = typer.main.get_command(app)


def code_lines(text: str) -> list[str]:
    """Return the lines of all fenced blocks, those that end in a backslash joined."""
    blocks = re.findall(r"^```[^\n]*\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return "\n".join(blocks).replace("\\\n", " ").splitlines()


def commands(text: str, program: str) -> list[str]:
    """Return what documents call: in blocks, with or without a prompt, and between backticks."""
    inline = re.findall(r"`([^`]+)`", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))
    lines = [line.removeprefix("$ ") for line in (*code_lines(text), *inline)]
    pattern = rf"(?:\S*/)?{program}\s"
    return [" ".join(line.split()) for line in lines if re.match(pattern, line)]


def table_of(heading: str) -> list[list[str]]:
    """Return the cells of each row of the table whose first column has this heading."""
    rows = re.search(rf"^\| {re.escape(heading)} \|.*\n\|[-| ]+\n((?:\|.*\n)+)", EVERYTHING, re.M)
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows[1].splitlines()]


def names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


CALLS = [call for text in ALL_DOCUMENTS.values() for call in commands(text, "tissue_probe")]
LAUNCHES = [
    words[3:] for call in commands(EVERYTHING, "ros2") if "launch" in (words := call.split())
]


def test_the_documents_show_every_command():
    assert {shlex.split(call)[1] for call in CALLS} >= set(PROGRAM.commands)


@pytest.mark.parametrize("call", sorted(set(CALLS)))
def test_a_command_line_is_understood(call):
    # Parsed to the end, only not run: an unknown command or option, or a bad value, is refused.
    words = shlex.split(call)[1:]
    if words[0].startswith("-"):
        known = {name for option in PROGRAM.get_params(_context()) for name in option.opts}
        assert set(words) <= known | {"-h", "--help"}
        return
    command = PROGRAM.commands[words[0]]
    if len(words) > 1 and "--help" not in words:  # a command alone is only spoken of
        command.make_context(words[0], words[1:], parent=_context())


def _context():
    return typer.Context(PROGRAM, info_name="tissue_probe")


@pytest.mark.parametrize("document", ALL_DOCUMENTS)
def test_every_relative_link_and_picture_exists(document):
    text = re.sub(r"^```.*?^```", "", ALL_DOCUMENTS[document], flags=re.M | re.S)
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    for target in targets:
        if "://" not in target:
            name, _, place = target.partition("#")
            path = (ROOT / document).parent.joinpath(name) if name else ROOT / document
            assert path.exists(), target
            assert not place or place in headings(path.read_text(encoding="utf-8")), target


def headings(text: str) -> set[str]:
    """Return the places of a document that a link may name."""
    return {
        re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")
        for heading in re.findall(r"^#+ (.*)$", text, re.M)
    }


@pytest.mark.parametrize("document", ALL_DOCUMENTS)
def test_every_file_that_is_named_exists(document):
    roots = (ROOT, ROOT / "tissue_probe")
    pattern = r"(?:[\w.]+/)+[\w*]+\.(?:py|yaml|txt|msg|toml)"
    found = set(re.findall(rf"`({pattern})`", ALL_DOCUMENTS[document]))
    examples = {name for name in found if "/my_" in name}
    for name in found - examples:
        assert any(list(root.glob(name)) for root in roots), name


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md"])
def test_every_make_target_exists(document):
    text = ALL_DOCUMENTS[document]
    named = {target for call in commands(text, "make") for target in call.split()[1:2]}
    named |= set(re.findall(r"`make ([\w-]+)`", text))
    rules = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    assert named
    assert named <= rules


def test_the_readme_names_the_two_commands_and_what_ci_calls():
    lines = code_lines(README)
    assert "make demo" in lines
    assert "make test" in lines
    assert "make test" in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()


def published_as(topic: str) -> str:
    """Return how the nodes' sources write a topic that the documents name."""
    return topic.removeprefix("/stage/").replace("<estimator>/", "{self._name}/")


@pytest.mark.parametrize("row", table_of("topic (in `/probe`)"), ids=lambda row: row[0])
def test_every_topic_is_published_with_its_type(row):
    topics, (type_name, *_) = names(row[0]), names(row[1])
    package, _, name = type_name.split("/")
    assert re.search(rf"from {package}(?:\.msg)? import .*\b({name}|msg)\b", SOURCES)
    for topic in topics:
        literal = published_as(topic)
        if name == "Float64":  # published from a list of names
            assert re.search(rf'"{literal.rpartition("/")[2]}"', SOURCES)
            continue
        publishes = rf'(?:create_publisher|publish)\(\s*(?:msg\.)?{name}, f?"(\{{self\.name\}}/)?'
        assert re.search(publishes + re.escape(literal) + '"', SOURCES), topic


def test_every_published_topic_is_documented():
    named = {
        published_as(topic) for row in table_of("topic (in `/probe`)") for topic in names(row[0])
    }
    literals = re.findall(r'create_publisher\(\s*[\w.]+, f?"(?:\{self\.name\}/)?([^"]+)"', SOURCES)
    assert literals
    assert set(literals) <= named


@pytest.mark.parametrize("row", table_of("symbol"), ids=lambda row: row[1])
def test_every_field_in_the_table_of_signs_is_in_a_message(row):
    messages = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "msg_defs" / "msg").glob("*.msg")
    )
    for field in names(row[1]):
        assert re.search(rf"^\w+(?:\[\])? {field}\b", messages, re.M)


def test_the_table_of_estimators_has_each_of_them():
    assert {name for row in table_of("name") for name in names(row[0])} == set(ESTIMATORS)


#: Services and actions that the table of executables names beside their parameters.
SERVICES = {
    *("scan_grid", "replay/pause", "tare", "emergency_stop", "reset"),
    *("identify_sensor", "sensor/re_zero", "monitor/diagnose", "identify"),
}


def test_every_executable_and_parameter_exists():
    rows = table_of("executable")
    executables = {name for row in rows for name in names(row[0])}
    modules = {path.stem for path in NODES.glob("*.py") if "def main()" in path.read_text("utf-8")}
    assert executables == (modules - {"estimator"}) | set(ESTIMATORS)
    fields = set(
        re.findall(r"^    (\w+): \S.* = setting\($|^    (\w+): .* setting\(", SOURCES, re.M)
    )
    known = {name for pair in fields for name in pair}
    known |= set(EstimatorSettings.model_fields) | set(Limits.model_fields)
    known |= set(MonitorSettings.model_fields)
    known |= set(RobotDescription.model_fields)
    known |= {name for device in DEVICES.values() for name in device.settings.model_fields}
    for row in rows:
        for cell in names(row[1]):
            if cell.startswith("tissue_probe ") or cell in SERVICES:
                continue
            assert cell.rpartition(".")[2] in known, cell


@pytest.mark.parametrize("words", LAUNCHES, ids=lambda words: words[0])
def test_every_launch_file_declares_the_arguments_shown(words):
    file, *arguments = words
    text = (ROOT / "launch" / file).read_text(encoding="utf-8")
    shared = (ROOT / "launch" / "estimation.launch.py").read_text(encoding="utf-8")
    for argument in arguments:
        assert f'"{argument.partition(":=")[0]}"' in text + shared


def test_every_package_that_is_imported_and_required_is_explained():
    rows = re.search(r"^\| package \| why \|\n\|[-|]+\n((?:\|.*\n)+)", DEPENDENCIES, re.M)[1]
    explained = {
        name.strip().lower() for row in rows.splitlines() for name in row.split("|")[1].split(",")
    }
    names = ("python.txt", "daq.txt", "workbench.txt", "study.txt", "development.txt", "docs.txt")
    files = (ROOT / "requirements" / name for name in names)
    required = {
        re.match(r"[\w-]+", line)[0].lower()
        for file in files
        for line in file.read_text(encoding="utf-8").splitlines()
        if line and not line.startswith("#")
    }
    assert explained <= required
    code = "\n".join(
        path.read_text(encoding="utf-8")
        for folder in ("tissue_probe", "test", "benchmarks")
        for path in (ROOT / folder).rglob("*.py")
    )
    for name in required - explained:
        assert not re.search(rf"^\s*(?:import|from) {name}\b", code, re.M), name


def test_the_python_snippet_reads_a_recording(tmp_path, monkeypatch, capsys):
    recordings = ALL_DOCUMENTS["docs/recordings.md"]
    snippet = re.search(r"^```python\n(.*?)^```", recordings, re.M | re.S)[1]
    from mcap.writer import Writer

    monkeypatch.chdir(tmp_path)
    with open("run.mcap", "wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        text = "uint64 sequence\nfloat64 stiffness\nfloat64 damping\n"
        schema = writer.register_schema("test/msg/Estimate", "ros2msg", text.encode())
        channel = writer.register_channel("/probe/ekf/estimate", "cdr", schema)
        data = bytes([0, 1, 0, 0]) + (7).to_bytes(8, "little") + bytes(16)
        writer.add_message(channel, 1, data, 1)
        writer.finish()
    exec(compile(snippet, "docs/recordings.md", "exec"), {})
    assert capsys.readouterr().out == "7 0.0 0.0\n"


#: Modules in which a number may decide what is said to be missing.
DECIDING = adequacy, posterior, rules, moves, queue, ladder, harmonic, loop


def _numbers(module) -> dict[str, float]:
    """Return the numeric constants that a module itself defines, but for those that follow."""
    text = Path(module.__file__).read_text(encoding="utf-8")
    own = re.findall(r"^([A-Z_]+(?:, [A-Z_]+)*) = (?!float\()", text, re.M)
    names = [name for each in own for name in each.split(", ")]
    return {
        n: float(getattr(module, n)) for n in names if isinstance(getattr(module, n), int | float)
    }


def test_the_thresholds_of_the_diagnosis_are_those_of_the_code():
    rows = []
    for names, values in re.findall(r"^\| (`[A-Z_`, ]+) \| ([\d., ]+) \|", DIAGNOSIS, re.M):
        rows += zip(re.findall("[A-Z_]+", names), values.split(", "), strict=True)
    deciding = {name: value for module in DECIDING for name, value in _numbers(module).items()}
    known = {**vars(problem), **vars(visibility), **deciding}
    assert {name: float(value) for name, value in rows} == {n: float(known[n]) for n, _ in rows}
    assert set(deciding) <= {name for name, _ in rows}
    # Each new one is another rule to be understood: better take one away.
    assert len(deciding) <= 27
