"""The command ``bench``: one module a command, each with ``register(app)``."""

from __future__ import annotations

import os
import sys
import traceback
from importlib import import_module
from importlib.util import find_spec
from inspect import cleandoc
from typing import Annotated

import typer

from bench.cli._pipes import let_pipes_close
from bench.cli._plain import PlainConsole, plain, say
from bench.cli.exit_codes import ExitCode, exit_code_help, exit_code_of
from bench.errors import BenchError
from bench.version import __version__

COMMANDS: tuple[str, ...] = (
    "run",
    "stop",
    "acts",
    "commission",
    "serve",
    "plan",
    "config",
    "inspect",
    "validate",
    "repair",
    "export",
    "import_",
    "identify",
    "compare",
    "trend",
    "compensate",
    "mismatch",
    "investigate",
    "predict",
    "export_model",
    "prove",
    "emulate",
    "doctor",
    "benchmark",
)
"""Modules of :mod:`bench.cli`, in the order in which ``bench --help`` lists their commands."""

_DEBUG = "BENCH_DEBUG"
"""Environment variable: set, errors come with their traceback."""


def make_app() -> typer.Typer:
    """Return the application with every command registered."""
    app = typer.Typer(
        name="bench",
        help="A gearbox test bench: run campaigns, inspect recordings, identify the gearbox, find missing physics.\n\n"
        + exit_code_help(),
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode="rich",
    )
    app.callback()(_begin)
    for name in COMMANDS:
        if find_spec(f"bench.cli.{name}") is not None:
            import_module(f"bench.cli.{name}").register(app)
    for command in app.registered_commands:
        command.help = _paragraphs(command.help or getattr(command.callback, "__doc__", None) or "")
    return app


def _say_version(wanted: bool) -> None:
    if wanted:
        say(f"gearbench {__version__}")
        raise typer.Exit


def _begin(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and end.", is_eager=True, callback=_say_version)
    ] = False,
) -> None:
    """Take the options that stand before any command."""


def _paragraphs(text: str) -> str:
    """Join the lines of each paragraph, so that help fills the terminal's width whatever the source's."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in cleandoc(text).split("\n\n"))


def main() -> None:
    """Run the command line; errors a user can mend are one sentence on stderr and a documented exit code."""
    # matrices here are small: threads of the linear algebra cost more than they save, on a busy computer many times
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    let_pipes_close()
    console = PlainConsole(stderr=True, highlight=False, soft_wrap=True)
    try:
        make_app()()
    except BenchError as error:
        if os.environ.get(_DEBUG):
            traceback.print_exc()
        console.print("[bold red]error:[/]", end=" ")
        console.print(plain(error), markup=False)
        sys.exit(exit_code_of(error))
    except ModuleNotFoundError as error:
        extra = _EXTRAS.get((error.name or "").partition(".")[0])
        if extra is None or os.environ.get(_DEBUG):
            raise
        console.print("[bold red]error:[/]", end=" ")
        console.print(f"this needs {error.name}; install it with pip install 'gearbench[{extra}]'", markup=False)
        sys.exit(ExitCode.BAD_INPUT)
    except OSError as error:
        # a path of the command line that cannot be used; anything without a path is a fault of this program
        if error.filename is None or os.environ.get(_DEBUG):
            raise
        console.print("[bold red]error:[/]", end=" ")
        console.print(_of_path(error), markup=False)
        sys.exit(ExitCode.BAD_INPUT)
    except KeyboardInterrupt:
        console.print("interrupted", markup=False)
        sys.exit(ExitCode.INTERRUPTED)


_EXTRAS: dict[str, str] = {
    "nptdms": "tdms",
    "pyarrow": "parquet",
    "asammdf": "mdf",
    "fmpy": "fmu",
    "distributed": "dask",
    "pysindy": "peers",
    "sysidentpy": "peers",
    "gplearn": "peers",
    "pyoperon": "formula",
    "sklearn": "peers",
    "kickcat": "conformance",
    "apprise": "notify",
}
"""Packages that are not always there, by the name they are imported with, and the extra that brings them."""

_OF_PATHS: dict[type[OSError], str] = {
    FileNotFoundError: "there is no such file or folder",
    FileExistsError: "it is a file, and a folder is wanted",
    NotADirectoryError: "a part of it is a file, and a folder is wanted",
    IsADirectoryError: "it is a folder, and a file is wanted",
    PermissionError: "you may not read or write it",
}


def _of_path(error: OSError) -> str:
    why = next((text for kind, text in _OF_PATHS.items() if isinstance(error, kind)), error.strerror or str(error))
    return f"{error.filename} cannot be used: {why}"
