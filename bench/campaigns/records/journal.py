"""The journal of a campaign folder (SQLite, WAL): what was begun, what became of it. It survives any kill.

A take is written down before its file exists and again when the file has its final name. What lies between after a
kill is settled when the journal is opened: a finished file is adopted, an unfinished one repaired into a recording cut
short.
"""

from __future__ import annotations

import fcntl
import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from hashlib import pbkdf2_hmac, sha256
from pathlib import Path
from types import TracebackType

from bench.campaigns.planning.definition import Campaign
from bench.campaigns.records.rebuilt import is_broken, put_aside, rebuild, require_whole
from bench.campaigns.taken import Status, Taken
from bench.configuration import BenchFile
from bench.errors import ConfigurationError, DeviceError, RecordingError
from bench.recording import Recording
from bench.recording.header import PART_SUFFIX
from bench.recording.repairing import repair

NAME, LOCK = "journal.sqlite", "journal.lock"
_BEGUN = "begun"
_SLOW = 20_000
"""rounds of the hash of a plant's name: some 10 ms"""
_SCHEMA = """
CREATE TABLE IF NOT EXISTS campaign (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS takes (
    recording_id TEXT PRIMARY KEY, point_id TEXT NOT NULL, take INTEGER NOT NULL,
    status TEXT NOT NULL, content TEXT NOT NULL
);
"""


def campaign_digest(campaign: Campaign) -> str:
    """Hash of what is to be measured; titles and comments do not count."""
    return sha256(repr((campaign.name, campaign.stages)).encode()).hexdigest()


def require_same(folder: Path, campaign: Campaign, file: BenchFile) -> None:
    """Refuse a folder that holds another campaign; nothing is written, so it may be asked before anything is queued.

    Raises
    ------
    ConfigurationError
        As :class:`Journal` does.
    """
    path = folder / NAME
    if not path.exists():
        return
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as database:
            kept = dict(database.execute("SELECT key, value FROM campaign").fetchall())
    except sqlite3.Error:
        # the run itself puts a damaged journal aside, and looks at what the recordings say
        return
    for key, digest, what in _claims(campaign, file):
        if kept.get(key, digest) != digest:
            raise _wrong_folder_error(folder, what)


def _claims(campaign: Campaign, file: BenchFile) -> tuple[tuple[str, str, str], ...]:
    return (
        ("campaign", campaign_digest(campaign), f'campaign "{campaign.name}" as it is now'),
        ("bench", file.digest, f'the configuration of bench "{file.configuration.name}" as it is now'),
    )


def _claim_of_plant(file: BenchFile) -> tuple[tuple[str, str, str], ...]:
    """What plays an emulated bench, which its text does not say where physics is concealed.

    The name of such a plant has its seed in it: only a hash is kept, made slow so that no seed is found by trying.
    """
    plant = file.configuration.bus.plant
    if plant is None:
        return ()
    hashed = pbkdf2_hmac("sha256", plant.encode(), file.digest.encode(), _SLOW)
    return (("plant", hashed.hex(), "the plant that plays the bench now (--conceal)"),)


def _wrong_folder_error(folder: Path, what: str) -> ConfigurationError:
    return ConfigurationError(
        f"{folder} holds recordings that were not made with {what}; give another folder with --out"
    )


def _lock(path: Path) -> int:
    """Lock the folder of a run for this process; the lock ends with it, however it ends."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        other = os.pread(descriptor, 32, 0).decode("ascii", "replace").strip() or "unknown"
        os.close(descriptor)
        raise DeviceError(f"{path.parent} is in use by a run in process {other}; wait for its end") from error
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, str(os.getpid()).encode(), 0)
    return descriptor


def _connect(path: Path) -> sqlite3.Connection:
    database = sqlite3.connect(path, check_same_thread=False, isolation_level=None)
    try:
        database.execute("PRAGMA journal_mode=WAL")
        # FULL: a commit is on the disk when it returns, so that a power cut takes back nothing
        database.execute("PRAGMA synchronous=FULL")
        database.executescript(_SCHEMA)
        require_whole(database)
    except BaseException:
        database.close()
        raise
    return database


def _row(taken: Taken, status: str | None = None) -> tuple[str, str, int, str, str]:
    content = json.dumps(taken.as_dict())
    return taken.recording_id, taken.point_id, taken.take, status or taken.status.value, content


class Journal:
    """The journal of one folder.

    Parameters
    ----------
    folder : of the recordings; is made if it is not there.
    campaign, file : what is measured and under which configuration.

    Attributes
    ----------
    notes : sentences about a journal that could not be read, and was made anew from the recordings.

    Raises
    ------
    ConfigurationError
        If the folder holds another campaign, one of another bench configuration, or of another plant: points would be
        mixed.
    DeviceError
        If another run works in the folder.
    """

    def __init__(self, folder: Path, campaign: Campaign, file: BenchFile) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self.notes: list[str] = []
        self._lock = _lock(folder / LOCK)
        try:
            self._database = self._open()
        except BaseException:
            os.close(self._lock)
            raise
        try:
            for key, digest, what in (*_claims(campaign, file), *_claim_of_plant(file)):
                if self.remember(key, digest) != digest:
                    raise _wrong_folder_error(folder, what)
            self._settle()
        except BaseException:
            self.close()
            raise

    def remember(self, key: str, value: str) -> str:
        """Keep a value if there is none under this key yet; return the one that is kept."""
        self._database.execute("INSERT OR IGNORE INTO campaign VALUES (?, ?)", (key, value))
        (kept,) = self._database.execute("SELECT value FROM campaign WHERE key = ?", (key,)).fetchone()
        return str(kept)

    def takes(self) -> list[Taken]:
        """All takes that have ended, in the order in which they were begun."""
        rows = self._database.execute("SELECT content FROM takes WHERE status != ? ORDER BY rowid", (_BEGUN,))
        return [Taken.from_dict(json.loads(content)) for (content,) in rows]

    def done(self) -> set[str]:
        """Ids of the points that have a take that passed."""
        rows = self._database.execute("SELECT DISTINCT point_id FROM takes WHERE status = ?", (Status.DONE.value,))
        return {str(point) for (point,) in rows}

    def next_take(self, point: str) -> int:
        """Return the number of the next take of a point, from 1."""
        (last,) = self._database.execute("SELECT MAX(take) FROM takes WHERE point_id = ?", (point,)).fetchone()
        return 1 + (last or 0)

    def begin(self, taken: Taken) -> None:
        """Write down that a recording is about to be made."""
        self._store_take(taken, _BEGUN)

    def end(self, taken: Taken) -> None:
        """Write down what became of it; its file has its final name."""
        self._store_take(taken, taken.status.value)

    def close(self) -> None:
        """Close the database and let go of the folder."""
        self._database.close()
        os.close(self._lock)

    def __enter__(self) -> Journal:
        """Nothing to do: it is open."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _open(self) -> sqlite3.Connection:
        """Open the database; one that is damaged is put aside, made anew from the recordings, and reported."""
        path = self._folder / NAME
        try:
            database = _connect(path)
            if database.execute("SELECT 1 FROM campaign").fetchone() is not None:
                return database
            why = "was empty or gone"
        except (sqlite3.Error, ValueError, KeyError, TypeError, RecursionError) as error:
            if not is_broken(error):
                raise DeviceError(f"{path} cannot be opened: {error}; make room, or wait for whoever has it") from error
            why = f"could not be read ({error}); it is kept as {put_aside(path)}"
            database = _connect(path)
        found = rebuild(self._folder)
        database.executemany("INSERT OR REPLACE INTO campaign VALUES (?, ?)", found.kept.items())
        database.executemany("INSERT OR REPLACE INTO takes VALUES (?, ?, ?, ?, ?)", map(_row, found.takes))
        if found.takes or "read" in why:
            self.notes = [f"{path} {why}; it was made anew from {len(found.takes)} recordings", *found.notes]
        return database

    def _store_take(self, taken: Taken, status: str) -> None:
        with self._transaction():
            self._database.execute("INSERT OR REPLACE INTO takes VALUES (?, ?, ?, ?, ?)", _row(taken, status))

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        try:
            self._database.execute("BEGIN IMMEDIATE")
            yield
            self._database.execute("COMMIT")
        except BaseException as error:
            if self._database.in_transaction:
                self._database.execute("ROLLBACK")
            if isinstance(error, sqlite3.OperationalError):
                raise DeviceError(
                    f"{self._folder / NAME} cannot be written: {error}; make room and run again"
                ) from error
            raise

    def _settle(self) -> None:
        rows = self._database.execute("SELECT content FROM takes WHERE status = ?", (_BEGUN,)).fetchall()
        for (content,) in rows:
            taken = Taken.from_dict(json.loads(content))
            settled = self._settle_take(taken)
            if settled is not None:
                self.end(settled)
            else:
                self._database.execute("DELETE FROM takes WHERE recording_id = ?", (taken.recording_id,))

    def _settle_take(self, taken: Taken) -> Taken | None:
        """Return what became of a take that was begun but not ended, None if nothing of it reached the disk."""
        path = self._folder / taken.file
        part = path.with_name(path.name + PART_SUFFIX)
        if not path.exists():
            if not part.exists():
                return None
            for orphan in self._folder.glob(f"{path.name}.repair*"):
                # a repair that was killed itself: what it copied is still in the unfinished file
                orphan.unlink()
            try:
                repair(part)
            except RecordingError:
                # no row was saved: the empty file is kept beside, its name is free for the next take
                part.rename(part.with_name(part.name + ".empty"))
                return None
        try:
            recording = Recording.open(path)
        except RecordingError as error:
            return replace(taken, status=Status.FAILED, note=str(error))
        passed = recording.complete and bool(recording.accepted)
        return replace(
            taken,
            status=Status.DONE if passed else Status.FAILED,
            note="" if passed else "cut short",
            quality=recording.quality,
            samples=recording.size,
            duration_s=recording.size / recording.sample_rate,
            complete=recording.complete,
        )
