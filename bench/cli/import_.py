"""``bench import``: other laboratories' measurements become recordings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._import_notes import different_numbers, together
from bench.cli._plain import line, say
from bench.cli.exit_codes import ExitCode

if TYPE_CHECKING:
    from bench.importing import Imported
    from bench.recording import Rejected

_NAMED = 5
"""recordings or files of which something that was said of another already is told by their names"""
_SHOWN = 5
"""files with the same channels that are told in a line each; the others are told together"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="import")(import_)


def import_(
    mapping: Annotated[
        Path | None, typer.Argument(help="TOML file: which variable is which channel, in which unit.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder the recordings go to.")] = None,
    data: Annotated[
        Path | None, typer.Option("--data", help="Folder of the files to import; default: that of the mapping.")
    ] = None,
    look: Annotated[
        str | None,
        typer.Option("--look", help="A file (or 'run*.csv'): show what is in it, write a mapping to begin with."),
    ] = None,
    asking: Annotated[
        str | None, typer.Option("--ask", help="The same, asking for what is open; with --out imports at once.")
    ] = None,
    written: Annotated[
        Path | None, typer.Option("--mapping", help="Where --look and --ask write it; default: NAME_OF_THE_FILE.toml.")
    ] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE that comes before the mapping's, as gearbox.ratio=50.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Import MAT, HDF5, NumPy, text (CSV of any separator), TDMS, Parquet or MDF files through a mapping file.

    docs/your-data.md goes from --look to a report, docs/recordings.md has all keys of a mapping. What a missing channel
    rules out is said in one sentence, and so is what had to be done to the data. Exit code 6 when a file could not be
    imported; the others are.
    """
    from bench.cli._import_look import look as look_at

    if sum(option is not None for option in (mapping, look, asking)) != 1:
        raise typer.BadParameter("one of MAPPING, --look FILE and --ask FILE should be given.")
    given = parsed_changes(changes or [])
    file = look or asking
    if file is not None:
        mapping = look_at(file, written, given, asking=asking is not None, as_json=as_json)
        if asking is None or out is None:
            return
        given = {}
    if out is None:
        raise typer.BadParameter("--out should name the folder the recordings go to.")
    assert mapping is not None
    _import(mapping, out, data, given, as_json=as_json)


def _import(mapping: Path, out: Path, data: Path | None, changes: dict[str, Any], *, as_json: bool) -> None:
    from bench.importing import import_recordings
    from bench.recording import Rejected
    from bench.recording.manifest import rebuild, write_manifest

    rows: list[dict[str, Any]] = []
    ruled_out: dict[str, int] = {}
    warned: dict[str, list[str]] = {}
    noted: dict[str, list[str]] = {}
    alike: dict[tuple[str, ...], list[list[Imported]]] = {}
    refused: dict[str, list[str]] = {}
    files = 0
    for _, group in groupby(import_recordings(mapping, out, data, changes), key=_origin):
        pieces: list[Imported] = []
        for done in group:
            if isinstance(done, Rejected):
                rows.append({"source": str(done.file), "error": done.why})
                same_words = refused.setdefault(_without_file(done), [])
                if not same_words and not as_json:
                    say(line(done.why))
                same_words.append(done.file.name)
            else:
                pieces.append(done)
                rows.append(_row(done))
        files += bool(pieces)
        for sentence in dict.fromkeys(consequence for piece in pieces for consequence in _consequences(piece)):
            ruled_out[sentence] = ruled_out.get(sentence, 0) + 1
        for sentence in dict.fromkeys(note for piece in pieces for note in piece.notes):
            noted.setdefault(sentence, []).append(pieces[0].recording.path.stem)
        if pieces and not as_json:
            same = alike.setdefault(tuple(pieces[0].recording.channels), [])
            same.append(pieces)
            _print_recordings(pieces, warned, in_full=len(same) <= _SHOWN)
    for same in alike.values():
        if len(same) > _SHOWN:
            say(_summary(same[_SHOWN:]))
    for first, *others in refused.values() if not as_json else ():
        if others:
            say(line(f"{_first(others)} could not be imported for the same reason as {first}"))
    for words, (_, *others) in warned.items() if not as_json else ():
        if others:
            say(line(f"the same warning, with other numbers, of {_first(others)}: {words}"))
    for sentence, names in together(noted, _SHOWN).items() if not as_json else ():
        only = f"{names[0]}: {sentence}" if len(names) == 1 else f"in {len(names)} of {files} files {sentence}"
        say(line(sentence if files == 1 else only))
    for sentence, count in ruled_out.items() if not as_json else ():
        say(line(sentence if files == 1 else f"in {count} of {files} files {sentence}"))
    if any("recording" in row for row in rows):
        write_manifest(out, rebuild(out))
    if as_json:
        say(json.dumps(rows, ensure_ascii=False))
    if any("error" in row for row in rows):
        raise typer.Exit(ExitCode.NOT_VALID)


def _without_file(refused: Rejected) -> str:
    """Why a file was refused, without its name: of many files it is mostly the same."""
    return refused.why.replace(str(refused.file), "…").replace(refused.file.name, "…")


def _first(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{', '.join(names[:_NAMED])}{more}"


def _origin(done: Imported | Rejected) -> tuple[str, ...]:
    """What pieces of one file with the same channels have in common."""
    from bench.recording import Rejected

    return (str(done.file),) if isinstance(done, Rejected) else (str(done.source), *done.recording.channels)


def _row(done: Imported) -> dict[str, Any]:
    recording = done.recording
    return {
        "source": str(done.source),
        "recording": str(recording.path),
        "rows": recording.size,
        "sample_rate": recording.sample_rate,
        "channels": recording.channels,
        "consequences": done.consequences,
        "notes": done.notes,
        "warnings": done.warnings,
    }


def _consequences(done: Imported) -> list[str]:
    """What a recording's missing channels rule out, without its name: pieces and files mostly lack the same ones."""
    return [sentence.removeprefix(f"{done.recording.path}: ") for sentence in done.consequences]


def _told(pieces: Sequence[Imported]) -> str:
    """Names of recordings with the same channels, how many there are, and what they hold."""
    recordings = [piece.recording for piece in pieces]
    rows = sum(recording.size for recording in recordings)
    name = str(recordings[0].path)
    if len(recordings) > 1:
        name += f" to {recordings[-1].path.name}"
    number = f"{len(recordings)} recordings, " if len(recordings) > 1 else ""
    seconds = sum(recording.size / recording.sample_rate for recording in recordings)
    return f"{name}: {number}{rows} rows ({seconds:.1f} s) of {', '.join(recordings[0].channels)}"


def _summary(files: Sequence[Sequence[Imported]]) -> str:
    """The recordings of further files with the same channels, in a line."""
    more = f"{len(files)} more file{'s' * (len(files) > 1)}"
    return f"and {more}: {_told([piece for pieces in files for piece in pieces])}"


def _print_recordings(pieces: Sequence[Imported], warned: dict[str, list[str]], *, in_full: bool) -> None:
    """The recordings made of one file, in a line where that is ``in_full``, and what cannot be.

    ``warned``: of which recordings each warning was given, by its words; it is shown once.
    """
    if in_full:
        say(_told(pieces))
    shown: dict[str, str] = {}
    for sentence in (warning for piece in pieces for warning in piece.warnings):
        where, _, said = sentence.partition(": ")
        shown.setdefault(f"{where}: {different_numbers(said)}", sentence)
    for words, sentence in shown.items():
        given = warned.setdefault(words, [])
        given.append(pieces[0].recording.path.stem)
        if len(given) == 1:
            whose = "" if in_full else f"{pieces[0].recording.path.stem}: "
            say(f"  WARNING: {whose}{line(sentence)}")


def parsed_changes(given: list[str]) -> dict[str, Any]:
    """Read ``KEY=VALUE``: the value as TOML has it, or else as text.

    Raises
    ------
    ConfigurationError
        There is no ``=``.
    """
    import tomllib

    from bench.errors import ConfigurationError

    changes: dict[str, Any] = {}
    for text in given:
        key, found, value = text.partition("=")
        if not found or not key.strip():
            raise ConfigurationError(f"--set {text}: should be KEY=VALUE, such as gearbox.ratio=50.")
        try:
            changes[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            changes[key.strip()] = value.strip()
    return changes
