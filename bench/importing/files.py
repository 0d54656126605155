"""The files a recording comes from: found by pattern, opened once."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePath

from bench.errors import ConfigurationError, RecordingError
from bench.importing.channel_mapping import ChannelMapping
from bench.importing.formats import Source, open_source
from bench.importing.formats.text_layout import TextOptions
from bench.importing.mapping import RecordingMapping
from bench.names import require_name


@dataclass(slots=True)
class Files:
    """The main file of a recording, and those that single channels stand in; ``stars`` what ``*`` stood for.

    ``home`` is the folder that ``recordings.file`` counts from.
    """

    main: Path
    options: TextOptions
    stars: tuple[str, ...] = ()
    home: Path | None = None
    _open: dict[Path, Source] = field(default_factory=dict)

    def path(self, name: str | None) -> Path:
        """The file of a channel; the main one where it names none."""
        if name is None:
            return self.main
        for star in self.stars:
            name = name.replace("*", star, 1)
        return self.main.parent / name.replace("{stem}", self.main.stem)

    def source(self, name: str | None = None) -> Source:
        """Open the file of a channel, once.

        Raises
        ------
        RecordingError
            It is missing, or of a kind that is not known.
        """
        path = self.path(name)
        if path not in self._open:
            if not path.exists():
                raise RecordingError(self._missing(path, name))
            self._open[path] = open_source(path, self.options)
        return self._open[path]

    def notes(self) -> list[str]:
        """What was taken for granted in reading the files opened so far."""
        return list(dict.fromkeys(note for source in self._open.values() for note in source.notes))

    def _missing(self, path: Path, name: str | None) -> str:
        """Say what the name of a file that is not there was counted from, and which name would be right."""
        if name is None:
            home = f"{(self.home or self.main.parent).resolve()}"
            return (
                f"{path}: there is no such file; recordings.file counts from the folder of the mapping, or that of "
                f"--data: here {home}."
            )
        plain = Path(name).name
        near = f"; did you mean '{plain}'?" if plain != name and (self.main.parent / plain).is_file() else "."
        return (
            f"{path}: there is no such file; '{name}', the 'file' of a channel, counts from the folder of the "
            f"recording's own file {self.main.name}: {self.main.parent.resolve()}{near}"
        )


def in_folder(folder: Path, entries: Iterable[RecordingMapping], where: str) -> list[RecordingMapping]:
    """The entries with their files as they are called in the folder of ``--data``: a mapping counts from its own, and
    may have folders before a name that this one has not.

    Raises
    ------
    ConfigurationError
        Two of them would be one file.
    """
    there: dict[str, str] = {}
    out = []
    for entry in entries:
        name = _in_folder(folder, entry.file)
        other = there.setdefault(name, entry.file)
        if other != entry.file:
            raise ConfigurationError(
                f"{where}: recordings.file: '{other}' and '{entry.file}' would both be {folder / name}; --data should "
                "name the folder that both count from."
            )
        out.append(entry.model_copy(update={"file": name}))
    return out


def _in_folder(folder: Path, name: str) -> str:
    """The longest end of a name that is there; the name itself where none is."""
    parts = PurePath(name).parts
    for k, before in enumerate(parts):
        end = PurePath(*parts[k:]).as_posix()
        if _fitting(folder, end):
            return end
        if _is_pattern(before):
            break
    return name


def _is_pattern(name: str) -> bool:
    return any(mark in name for mark in "*?[")


def _fitting(folder: Path, name: str) -> list[Path]:
    """The files of a name or a pattern."""
    if not _is_pattern(name):
        return [folder / name] if (folder / name).is_file() else []
    return [] if PurePath(name).is_absolute() else sorted(path for path in folder.glob(name) if path.is_file())


def found(folder: Path, entry: RecordingMapping) -> list[tuple[Path, tuple[str, ...]]]:
    """Find the files of a recording's entry, with what the stars of its pattern stand for.

    Raises
    ------
    ConfigurationError
        No file fits the pattern, or one id would name several.
    """
    if not _is_pattern(entry.file):
        return [(folder / entry.file, ())]
    files = _fitting(folder, entry.file)
    if not files:
        raise ConfigurationError(
            f"{folder / entry.file}: no file fits this pattern of recordings.file, which counts from "
            f"{folder.resolve()}."
        )
    if len(files) > 1 and entry.recording_id is not None:
        raise ConfigurationError(
            f"recordings.recording_id '{entry.recording_id}' would name {len(files)} files of the pattern "
            f"'{entry.file}'; leave it out, each then has the name of its file."
        )
    return [(path, _stars(path.relative_to(folder).as_posix(), entry.file)) for path in files]


def refuse_shared(recordings: Iterable[tuple[Path, tuple[str, ...], Mapping[str, ChannelMapping]]], where: str) -> None:
    """Refuse a channel that would be read from one file for several recordings.

    A channel with a clock of its own may: a thermometer's log spans all recordings. So may the time, which is the same
    where a logger starts anew for each.

    Parameters
    ----------
    recordings : main file of each, what the stars of its pattern stand for, and its channels.

    Raises
    ------
    ConfigurationError
        A channel's file has no ``*`` and is read for several main files.
    """
    mains: dict[tuple[str, Path], dict[Path, tuple[str, ...]]] = {}
    for main, stars, channels in recordings:
        files = Files(main, TextOptions(), stars)
        for name, wanted in channels.items():
            named = {part.file for part in (wanted, *wanted.sum)} - {None}
            if name != "time" and wanted.time is None:
                for path in map(files.path, named):
                    if path != main:
                        mains.setdefault((name, path), {})[main] = stars
    for (name, path), of in mains.items():
        if len(of) > 1:
            starred = _starred(path.name, of.values())
            key = f"aux.{name.removeprefix('aux/')}" if name.startswith("aux/") else f"channels.{name}"
            raise ConfigurationError(
                f"{where}: {key}.file: '{path.name}' would be read for {len(of)} recordings, each should have its own; "
                f"'*' stands for what differs{f', such as {starred!r}' if starred else ''}, or the [[recordings]] have "
                "channels of their own."
            )


def _starred(name: str, stars: Iterable[tuple[str, ...]]) -> str:
    """The name of a file with ``*`` for what a pattern's star stands for in one of the recordings; empty if nowhere."""
    texts = sorted({text for one in stars for text in one if text and text in name}, key=len, reverse=True)
    return name.replace(texts[0], "*", 1) if texts else ""


def _stars(name: str, pattern: str) -> tuple[str, ...]:
    parts = [re.escape(part).replace(r"\?", ".") for part in pattern.split("*")]
    match = re.fullmatch("(.*)".join(parts), name)
    return match.groups() if match else ()


def ids(files: list[tuple[Path, tuple[str, ...]]], entry: RecordingMapping) -> list[str]:
    """Name the recordings of an entry: by its id, by the files' stems, or where these are alike by their folders."""
    if entry.recording_id is not None:
        names = [entry.recording_id]
    else:
        names = [path.stem for path, _ in files]
        if len(set(names)) != len(names):
            names = [f"{path.parent.name}-{path.stem}" for path, _ in files]
    return [require_name(name, "recordings.recording_id") for name in names]
