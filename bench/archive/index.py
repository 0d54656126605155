"""The index: one SQLite file over the folders below a root. All of it comes from the folders, so it may be deleted."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from bench.archive.facts import Facts, facts_of
from bench.archive.notes import FILE, Note, read_notes
from bench.archive.query import MOST, Query

T = TypeVar("T")
_VERSION = 1
_BUSY_S = 10.0
_FRESH_NS = 2_000_000_000
"""How long after a change another one may carry the same time: file systems count time in steps, FAT in 2 s."""
_LOOK_AGAIN = 0
"""Kept instead of the time of a fresh change: the folder is read again the next time."""
_COLUMNS = tuple(field.name for field in fields(Facts))
_SCHEMA = f"""
CREATE TABLE IF NOT EXISTS folders (name TEXT PRIMARY KEY, changed INTEGER, notes INTEGER);
CREATE TABLE IF NOT EXISTS files (folder TEXT, file TEXT, size INTEGER, changed INTEGER, PRIMARY KEY (folder, file));
CREATE TABLE IF NOT EXISTS recordings (
    {", ".join(_COLUMNS)}, person TEXT, tags TEXT, comments TEXT, archived INTEGER, text TEXT,
    PRIMARY KEY (folder, file));
CREATE INDEX IF NOT EXISTS by_time ON recordings (started_s DESC);
PRAGMA user_version = {_VERSION};
"""


@dataclass(frozen=True, slots=True)
class Found:
    """What a search found: recordings of this part of the answer, newest first, and how many there are at all.

    ``folders`` counts all that were found by folder, newest first.
    """

    total: int
    recordings: list[dict[str, Any]]
    folders: list[dict[str, Any]]


class Index:
    """Finds recordings below a root; several processes may use the same file.

    Parameters
    ----------
    root : folder of campaign folders.
    path : of the SQLite file; one that is broken, or of another version, is made anew.
    """

    def __init__(self, root: Path, path: Path) -> None:
        self._root, self._path = root, path

    def rebuild(self) -> int:
        """Delete the index and build it again from the folders; return how many recordings it holds."""
        self._remove()
        return self._take_up()

    def refresh(self) -> int:
        """Index what has changed in the folders; return how many recordings were read.

        A folder is looked into if it, or its notes, changed since: finished recordings never change in place.
        """
        return self._with_rebuild(self._take_up)

    def _take_up(self) -> int:
        folders = self._folders()
        with self._open() as database:
            known = {row[0]: row[1:] for row in database.execute("SELECT name, changed, notes FROM folders")}
        read = 0
        for gone in known.keys() - folders.keys():
            with self._open(writing=True) as database:
                _forget(database, gone)
        for name, stamps in folders.items():
            if stamps[0] == _LOOK_AGAIN or known.get(name) != stamps:
                read += self._take(name, stamps)
        return read

    def search(self, query: Query) -> Found:
        """Search the index; call :meth:`refresh` first to include recordings that are new."""
        return self._with_rebuild(lambda: self._search(query))

    def _search(self, query: Query) -> Found:
        where, values = query.conditions()
        limit = max(0, min(query.limit, MOST))
        shown = ", ".join((*_COLUMNS, "person", "tags", "comments", "archived"))
        by_folder = (
            "SELECT folder AS name, MAX(campaign) AS campaign, COUNT(*) AS recordings, MIN(started_s) AS first_s,"
            " MAX(started_s) AS last_s, MAX(gearbox) AS gearbox, MAX(bench) AS bench, MAX(person) AS person,"
            " SUM(result = 'passed') AS passed, MIN(archived) AS archived"
            f" FROM recordings WHERE {where} GROUP BY folder ORDER BY last_s DESC"
        )
        with self._open() as database:
            database.row_factory = sqlite3.Row
            rows = database.execute(
                f"SELECT {shown} FROM recordings WHERE {where} ORDER BY started_s DESC, folder, file LIMIT ? OFFSET ?",
                [*values, limit, max(0, query.offset)],
            ).fetchall()
            # every folder is counted: what they hold together is the total, without looking at all of it once more
            folders = [dict(row) for row in database.execute(by_folder, values)]
        total = sum(folder["recordings"] for folder in folders)
        return Found(total, [_entry_of_row(row) for row in rows], folders[:MOST])

    # -- private -------------------------------------------------------------------------------------------------------

    def _folders(self) -> dict[str, tuple[int, int]]:
        """Return the folders below the root with the times of their last change and of their notes; links are none."""
        found = {}
        now = time.time_ns()
        for entry in self._root.iterdir() if self._root.is_dir() else ():
            if entry.name.startswith(".") or entry.is_symlink() or not entry.is_dir():
                continue
            try:
                notes = entry / FILE
                stamp = notes.stat() if notes.exists() else None
                changed = entry.stat().st_mtime_ns
                found[entry.name] = (
                    _LOOK_AGAIN if abs(now - changed) < _FRESH_NS else changed,
                    0 if stamp is None else stamp.st_mtime_ns + stamp.st_size,
                )
            except OSError:
                # taken away between listing and looking
                continue
        return found

    def _take(self, name: str, stamps: tuple[int, int]) -> int:
        """Read what is new in a folder, and its notes."""
        folder = self._root / name
        here = _files(folder)
        with self._open() as database:
            query = "SELECT file, size, changed FROM files WHERE folder = ?"
            known = {row[0]: (row[1], row[2]) for row in database.execute(query, [name])}
        new = sorted(file for file, stamp in here.items() if known.get(file) != stamp)
        facts = facts_of(folder, new)
        notes = read_notes(folder)
        with self._open(writing=True) as database:
            for gone in known.keys() - here.keys():
                database.execute("DELETE FROM recordings WHERE folder = ? AND file = ?", [name, gone])
                database.execute("DELETE FROM files WHERE folder = ? AND file = ?", [name, gone])
            marks = ", ".join("?" * (len(_COLUMNS) + 5))
            database.executemany(
                f"INSERT OR REPLACE INTO recordings VALUES ({marks})",
                [(*astuple(one), "", "\n", "", 0, "") for one in facts],
            )
            database.executemany(
                "INSERT OR REPLACE INTO files VALUES (?, ?, ?, ?)", [(name, file, *here[file]) for file in new]
            )
            _annotate(database, name, notes)
            database.execute("INSERT OR REPLACE INTO folders VALUES (?, ?, ?)", [name, *stamps])
        return len(new)

    @contextmanager
    def _open(self, *, writing: bool = False) -> Iterator[sqlite3.Connection]:
        """Open the file for one transaction; one that is ``writing`` takes its turn at the beginning.

        Who has read in a transaction and then writes is refused at once if another process wrote in between.
        """
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with closing(sqlite3.connect(self._path, timeout=_BUSY_S)) as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            if version not in (0, _VERSION):
                raise sqlite3.DatabaseError(f"version {version}")
            if version == 0:
                database.execute("PRAGMA journal_mode = WAL")
                database.executescript(_SCHEMA)
            with database:
                if writing:
                    database.execute("BEGIN IMMEDIATE")
                yield database

    def _with_rebuild(self, work: Callable[[], T]) -> T:
        """Return the result of ``work``; an index that is damaged or of another version is built again once before."""
        try:
            return work()
        except sqlite3.OperationalError:
            # locked, or the disk is full: making it anew would mend neither
            raise
        except sqlite3.DatabaseError:
            self._remove()
            self._take_up()
            return work()

    def _remove(self) -> None:
        for end in ("", "-wal", "-shm"):
            self._path.with_name(self._path.name + end).unlink(missing_ok=True)


def _files(folder: Path) -> dict[str, tuple[int, int]]:
    found = {}
    for entry in folder.iterdir() if folder.is_dir() else ():
        if entry.suffix not in (".h5", ".hdf5") or entry.is_symlink():
            continue
        try:
            seen = entry.stat()
        except OSError:
            continue
        found[entry.name] = (seen.st_size, seen.st_mtime_ns)
    return found


def _forget(database: sqlite3.Connection, folder: str) -> None:
    for table, column in (("recordings", "folder"), ("files", "folder"), ("folders", "name")):
        database.execute(f"DELETE FROM {table} WHERE {column} = ?", [folder])


def _annotate(database: sqlite3.Connection, folder: str, notes: list[Note]) -> None:
    """Write what the notes say beside the recordings of a folder, and the text that words are looked for in."""
    database.row_factory = sqlite3.Row
    for row in database.execute("SELECT * FROM recordings WHERE folder = ?", [folder]).fetchall():
        mine = [note for note in notes if note.file in ("", row["file"])]
        tags: list[str] = []
        for note in mine:
            if note.kind == "tag" and note.text not in tags:
                tags.append(note.text)
            elif note.kind == "untag" and note.text in tags:
                tags.remove(note.text)
        comments = [f"{note.at[:16]} {note.by}: {note.text}" for note in mine if note.kind == "comment"]
        person = next((note.text for note in reversed(mine) if note.kind == "person"), "")
        moved = next((note.kind for note in reversed(mine) if note.kind in ("archive", "restore")), "")
        said = [str(row[name]) for name in ("folder", "recording_id", "campaign", "kind", "gearbox", "bench", "words")]
        text = "\n".join((*said, person, *tags, *comments)).lower()
        database.execute(
            "UPDATE recordings SET person = ?, tags = ?, comments = ?, archived = ?, text = ?"
            " WHERE folder = ? AND file = ?",
            [
                person,
                "\n" + "".join(f"{tag}\n" for tag in tags),
                "\n".join(comments),
                int(moved == "archive"),
                text,
                folder,
                row["file"],
            ],
        )
    database.row_factory = None


def _entry_of_row(row: sqlite3.Row) -> dict[str, Any]:
    entry = dict(row)
    return {
        **entry,
        "tags": [tag for tag in entry["tags"].split("\n") if tag],
        "comments": [comment for comment in entry["comments"].split("\n") if comment],
        "archived": bool(entry["archived"]),
    }
