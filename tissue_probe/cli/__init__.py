"""The command line: one program beside the ROS executables.

Contents: arguments, and printed lines. Each command imports its modules when it runs, so that
``--help`` and shell completion answer at once.
"""

from __future__ import annotations

import sys

import typer

from tissue_probe import __version__
from tissue_probe.cli.admittance import admittance
from tissue_probe.cli.calibrate import calibrate
from tissue_probe.cli.challenge import challenge
from tissue_probe.cli.compare import compare
from tissue_probe.cli.contact import contact
from tissue_probe.cli.demo import demo
from tissue_probe.cli.diagnose import diagnose
from tissue_probe.cli.effects import effects
from tissue_probe.cli.estimate import estimate
from tissue_probe.cli.estimators import estimators
from tissue_probe.cli.excitation import excitation
from tissue_probe.cli.export import export
from tissue_probe.cli.improve import improve
from tissue_probe.cli.info import info
from tissue_probe.cli.joint import joint
from tissue_probe.cli.map import map_command
from tissue_probe.cli.modulus import modulus
from tissue_probe.cli.mujoco import mujoco
from tissue_probe.cli.options_named import with_options
from tissue_probe.cli.reproduce import reproduce
from tissue_probe.cli.sensor import sensor
from tissue_probe.cli.study import study
from tissue_probe.cli.workbench import workbench
from tissue_probe.one_line import sentence

app = typer.Typer(
    name="tissue_probe",
    help="Stiffness and damping of soft tissue from a vibrating palpation probe.",
    no_args_is_help=True,
    # Plain text, not markup: units stand in square brackets.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(demo)
app.command()(estimate)
app.command()(estimators)
app.command("map")(map_command)
app.command()(info)
app.command()(export)
app.command()(excitation)
app.command()(reproduce)
app.command()(compare)
app.command()(diagnose)
app.command()(improve)
app.command()(effects)
app.command()(sensor)
app.command()(contact)
app.command()(admittance)
app.command()(mujoco)
app.command()(joint)
app.command()(modulus)
app.command()(workbench)
app.add_typer(challenge, name="challenge")
app.add_typer(calibrate, name="calibrate")
app.add_typer(study, name="study")


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"tissue_probe {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Print the version."
    ),
) -> None:
    pass


def main() -> None:
    """Run the program; an error that the user can mend is told in one line."""
    try:
        app(prog_name="tissue_probe")
    except (ValueError, OSError) as error:
        # RecordingError and SettingsError are ValueErrors; each message is a sentence for the user.
        sys.exit(f"tissue_probe: {with_options(sentence(error))}")
