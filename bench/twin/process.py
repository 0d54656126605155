"""The twin as a process of its own, of the lowest priority: ``python -m bench.twin.process JOB.json``.

It reads recordings that are finished and nothing else, and says what it sees as lines of JSON. When its standard input
ends it looks at what is left and ends. It holds no lock, opens no bus, writes no recording: it cannot touch the cycle.
"""

from __future__ import annotations

import json
import os
import select
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bench.errors import BenchError, RecordingError
from bench.recording import Recording
from bench.twin.finding import found
from bench.twin.job import Job
from bench.twin.names import likely
from bench.twin.sentence import no_longer
from bench.twin.streams import AT_ONE_POINT
from bench.twin.watch import Watch
from bench.whole import write_whole

EVERY_S = 0.5
TRIES = 3
"""looks at a file that cannot be read before it is left out: somebody may be copying it"""
RESULT = "twin.json"
"""what the twin saw, beside the recordings"""


class Watching:
    """Looks at each recording of a folder once, in the order in which they were made."""

    def __init__(self, job: Job) -> None:
        self._job, self._watch = job, Watch(Path(job.model))
        self._done: set[Path] = set()
        self._tried: dict[Path, int] = {}

    @property
    def unread(self) -> dict[str, str]:
        """Recordings that could not be looked at, and why."""
        return dict(self._watch.unread)

    def look(self) -> list[dict[str, Any]]:
        """Compare new recordings; return the messages about them."""
        messages = []
        for recording in self._new():
            began = time.monotonic()
            alarmed = self._watch.add(recording)
            messages.append(self._comparison_message(recording, time.monotonic() - began))
            if alarmed:
                messages.append(self._alarm())
        if messages:
            state = {"format": "bench-twin-watch", "format_version": "1.0", **asdict(self._job), "said": messages[-1]}
            alarm = self._alarm() if self._watch.alarmed is not None else None
            content = state | {"no_longer_holds": alarm}
            write_whole(Path(self._job.folder) / RESULT, json.dumps(content, indent=1, ensure_ascii=False))
        return messages

    def _new(self) -> list[Recording]:
        paths = set(Path(self._job.folder).glob("*.h5")) - self._done
        fresh = []
        for path in paths:
            self._tried[path] = self._tried.get(path, 0) + 1
            try:
                fresh.append(Recording.open(path))
            except RecordingError as error:
                if self._tried[path] < TRIES:
                    continue
                self._watch.unread[path.stem] = str(error)
            self._done.add(path)
        return sorted(fresh, key=lambda r: r.started_at)

    def _comparison_message(self, recording: Recording, took_s: float) -> dict[str, Any]:
        watch = self._watch
        last = watch.seen[-1].evidence if watch.seen else 0.0
        return {
            "type": "looked",
            "recording": recording.recording_id,
            "compared": recording.kind in AT_ONE_POINT,
            "points": watch.points,
            "tested": watch.tested,
            "evidence": round(last, 3),
            "took_s": round(took_s, 3),
            "not_watched": dict(watch.without),
        }

    def _alarm(self) -> dict[str, Any]:
        finding = found(self._watch)
        assert finding is not None
        return no_longer(self._watch, finding, likely(self._watch, finding))


def main(path: str) -> int:
    """Watch until standard input ends and everything was looked at; 3 for a wrong model, said in a line."""
    job = Job(**json.loads(Path(path).read_text("utf-8")))
    os.nice(job.nice)
    watching = Watching(job)
    try:
        ending = False
        while True:
            for _ in range(TRIES if ending else 1):
                for line in watching.look():
                    say(line)
            if ending:
                break
            ready, _, _ = select.select([sys.stdin], [], [], EVERY_S)
            # whoever started it closes the pipe, or is gone: one more look, for the last recording
            ending = bool(ready) and sys.stdin.read(1) == ""
    except BenchError as error:
        say({"type": "ended", "why": str(error), "unread": watching.unread})
        return 3
    say({"type": "ended", "why": "", "unread": watching.unread})
    return 0


def say(message: dict[str, Any]) -> None:
    """One line of JSON."""
    sys.stdout.write(json.dumps(message, ensure_ascii=False) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
