"""The commands as cyclopts sees them: import strings, so that a command loads its own module only."""

from importlib import import_module

from cyclopts import App, CycloptsError

from ecfit.cli.overview import COMMANDS, name_of
from ecfit.errors import EcfitError

app = App(
    name="ecfit",
    version=lambda: import_module("ecfit").__version__,
    version_flags=["--version"],
    # Rich text in help would cost 0.1 s at every start.
    help_format="plaintext",
    # `main` says how to go on; cyclopts would end without a word.
    suppress_keyboard_interrupt=False,
)
for _command in (command for theme in COMMANDS.values() for command in theme):
    app.command(f"ecfit.cli.{_command}", name=name_of(_command.partition(":")[2]))


def call(arguments: list[str]) -> None:
    """Run the command that the words name; words that none understands are an `EcfitError`."""
    try:
        app(arguments, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        raise EcfitError(f"{' '.join(str(error).split())}; see ecfit --help") from error
