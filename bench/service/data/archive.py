"""The archive of one service: its index, what people note, and who had a campaign run."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

from bench.archive import Found, Index, Note, Query, add_note
from bench.campaigns.operator.remark import clean_remark
from bench.service.data import recordings
from bench.service.files.book import Book, local_time
from bench.service.models import NewNote
from bench.service.refusals import NotNow
from bench.service.runs.runs import Run
from bench.service.settings import Settings

_MOVED = {"archive": "put aside", "restore": "brought back"}


class Archive:
    """Finds recordings below the folder of a service; its methods may take long, and are called off the event loop."""

    def __init__(self, settings: Settings, book: Book) -> None:
        self._root, self._book = settings.folder, book
        self._index = Index(settings.folder, settings.state.absolute() / "archive.sqlite")

    def find(self, query: Query) -> Found:
        """Search the folders as they are now."""
        self._index.refresh()
        return self._index.search(query)

    def gearboxes(self) -> list[dict[str, Any]]:
        """Return serial numbers with how many campaigns there are of each."""
        from bench.trend import gearboxes

        self._index.refresh()
        return [{"serial": serial, "campaigns": count} for serial, count in gearboxes(self._index).items()]

    def trend(self, gearbox: str, since_s: float | None) -> dict[str, Any]:
        """Return a gearbox over its campaigns, of what is identified so far.

        Raises
        ------
        ConfigurationError
            If there is no campaign of it.
        """
        # what identifies is loaded when it is first asked for: the service begins without it
        from bench.trend import trend_of

        self._index.refresh()
        return trend_of(self._root, gearbox, self._index, since_s).as_dict()

    def note(self, new: NewNote) -> str:
        """Write a note into the folder it is about; return what was done.

        Raises
        ------
        BenchError
            If there is no such folder or file, or the note says nothing.
        """
        folder = recordings.inside(self._root, new.folder)
        if new.file is not None:
            recordings.inside(folder, new.file)
        text = clean_remark(new.text) if new.text.strip() else ""
        try:
            add_note(folder, Note(local_time(), new.name, new.kind, text, new.file or ""))
        except OSError as error:
            raise NotNow(f"{new.folder} takes no note: {error.strerror}") from error
        about = new.folder if new.file is None else f"{new.folder}, {new.file}"
        self._book.write("note", new.name, f"{new.kind} for {about}{': ' * bool(text)}{text}")
        return f"{new.kind}: {text}" if text else _MOVED[new.kind]

    def run_ended(self, run: Run) -> None:
        """Let the folder know who had it made: it is found by that later, also with another index.

        Returns at once: a disk that hangs holds up nobody who waits for the end of a run.
        """
        if run.measures:
            threading.Thread(target=self._name_person, args=(run,), name="name-person", daemon=True).start()

    def _name_person(self, run: Run) -> None:
        folder = Path(run.folder)
        try:
            if folder.is_dir():
                add_note(folder, Note(local_time(), "service", "person", run.by))
        except OSError as error:
            self._book.write("notice", "service", f"{folder.name} takes no note of who had it made: {error.strerror}")
