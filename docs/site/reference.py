"""Pages of reference that are made of the code: Python, commands, messages, parameters, JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
from pydantic import BaseModel

import tissue_probe
from tissue_probe.cli import app
from tissue_probe.settings import meaning, rule

ROOT = Path(__file__).parents[2]
#: Of results and arguments that the public names take or return, the classes that say more.
CLASSES = (
    "analysis.question:Asked",
    "analysis.comparing:ComparisonResult",
    "analysis.contact_export:AdmittanceResult",
    "analysis.contact_export:MujocoResult",
    "analysis.joint_export:JointResult",
    "analysis.contacting:ContactResult",
    "analysis.diagnosing:DiagnosisResult",
    "analysis.result_table:ResultTable",
    "analysis.sensing:SensorResult",
    "physics.fitted_model:FittedModel",
)
#: The settings of each node, by the prefix of their parameters.
NODES = {
    "driver": {
        "": "nodes.driver:DriverSettings",
        "limits.": "devices.limits:Limits",
        "excitation.": "nodes.driver:ExcitationSettings",
        "simulated.": "devices.simulated_settings:SimulatedProbeSettings",
        "nidaqmx.": "devices.nidaqmx.settings:NiDaqmxSettings",
    },
    "ekf, ukf, afekf, afukf, robust_ekf, lock_in, rls": {
        "": "nodes.estimator:EstimatorNodeSettings",
        "filter": "estimation.settings:EstimatorSettings",
    },
    "estimators": {"": "nodes.estimators:EstimatorsSettings"},
    "identify": {"": "nodes.identify:IdentifySettings"},
    "mapper": {"": "nodes.mapper:MapperSettings"},
    "monitor": {"": "monitoring.settings:MonitorSettings"},
    "scan": {"": "nodes.scan:ScanSettings"},
    "stage": {"": "nodes.stage:StageSettings"},
    "adapter": {"": "nodes.adapter:AdapterSettings"},
    "sensor": {"": "nodes.sensor:SensorSettings"},
    "recorder": {"": "nodes.recorder:RecorderSettings"},
    "replay": {"": "nodes.replay:ReplaySettings"},
}


def write_reference(folder: Path) -> None:
    """Write the pages into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = {
        "interface": _interface(),
        "commands": _commands(),
        "messages": _messages(),
        "parameters": _parameters(),
        "answer": _answer(),
    }
    for name, lines in pages.items():
        (folder / f"{name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _found(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(f"tissue_probe.{module}"), name)


def _interface() -> Iterator[str]:
    yield "# The Python interface, name by name\n"
    for name in tissue_probe.__all__:
        if name == "__version__":
            continue
        kind = "class" if isinstance(getattr(tissue_probe, name), type) else "function"
        yield f"## {name}\n"
        yield from _documented(kind, f"tissue_probe.{name}")
    yield "# Results and arguments\n"
    for place in CLASSES:
        yield f"## {place.partition(':')[2]}\n"
        yield from _documented("class", f"tissue_probe.{place.replace(':', '.')}")


def _documented(kind: str, path: str) -> Iterator[str]:
    yield f"```{{eval-rst}}\n.. auto{kind}:: {path}"
    if kind == "class":
        yield "   :members:"
    yield "```\n"


def _commands() -> Iterator[str]:
    program = typer.main.get_command(app)
    yield "# Commands and their options\n"
    yield "As `--help` tells them.\n"
    context = typer.Context(program, info_name="tissue_probe", **program.context_settings)
    yield from _command(program, context)


def _command(command: Any, context: typer.Context) -> Iterator[str]:
    for name, each in sorted(getattr(command, "commands", {}).items()):
        yield from _command(each, typer.Context(each, parent=context, info_name=name))
    if hasattr(command, "commands"):
        return
    formatter = context.make_formatter()
    formatter.width = 80
    command.format_help(context, formatter)
    yield f"## {context.command_path}\n"
    yield f"```text\n{formatter.getvalue().strip()}\n```\n"


def _messages() -> Iterator[str]:
    yield "# Messages and actions\n"
    yield "Of the package `tissue_probe_msgs`.\n"
    for kind in ("msg", "action"):
        for path in sorted((ROOT / "msg_defs" / kind).glob(f"*.{kind}")):
            yield f"## {path.stem}\n"
            yield f"```text\n{path.read_text(encoding='utf-8').strip()}\n```\n"


def _parameters() -> Iterator[str]:
    yield "# Parameters of the nodes\n"
    yield "As `ros2 param describe` tells them.\n"
    for node, groups in NODES.items():
        yield f"## {node}\n"
        yield "| parameter | default | takes | meaning |\n|---|---|---|---|"
        for prefix, place in groups.items():
            yield from _fields("" if prefix == "filter" else prefix, _found(place))
        yield ""


def _fields(prefix: str, settings: type[BaseModel]) -> Iterator[str]:
    for name, field in settings.model_fields.items():
        default = f"`{field.get_default(call_default_factory=True)}`".replace("``", "empty")
        cells = (f"`{prefix}{name}`", default, rule(field), meaning(field))
        yield f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"


def _answer() -> Iterator[str]:
    schema = json.loads((ROOT / "docs" / "diagnosis.schema.json").read_text(encoding="utf-8"))
    yield "# The answer in JSON\n"
    yield "The file that `--json` writes, by its schema.\n"
    yield from _keys("Answer", schema)
    for name, each in schema["$defs"].items():
        yield from _keys(name, each)


def _keys(name: str, schema: Mapping[str, Any]) -> Iterator[str]:
    yield f"## {name}\n"
    yield f"{schema.get('description', '')}\n"
    yield "| key | type | meaning |\n|---|---|---|"
    for key, told in schema.get("properties", {}).items():
        meant = told.get("description", "").replace("|", "&#124;")
        yield f"| `{key}` | {_type(told)} | {meant} |"
    yield ""


def _type(told: Mapping[str, Any]) -> str:
    if "$ref" in told:
        name = told["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "anyOf" in told:
        return " or ".join(_type(each) for each in told["anyOf"])
    if "enum" in told or "const" in told:
        return ", ".join(f"`{each}`" for each in told.get("enum", [told.get("const")]))
    if told.get("type") == "array":
        return f"list of {_type(told.get('items', {}))}"
    if isinstance(told.get("additionalProperties"), Mapping):
        return f"object of {_type(told['additionalProperties'])}"
    return str(told.get("type", "any"))
