"""The twin beside a run: starts its process, hears it, ends it. Nothing here waits for it while the bench moves."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bench.errors import ConfigurationError
from bench.twin.job import LOWEST, Job

Message = dict[str, Any]
KILL_S = 2.0


def require_model(model: Path) -> None:
    """Refuse a model that no twin can watch with, before anything is planned or run.

    Raises
    ------
    ConfigurationError
        There is no such file, or it is no simulation file.
    """
    # a service whose runs have no twin does without the numeric library
    from bench.simulation.model import Simulation

    if not model.is_file():
        raise ConfigurationError(f"{model}: there is no such model; bench identify writes one")
    Simulation.load(model)


class Companion:
    """The process of a twin.

    Parameters
    ----------
    model : simulation file, read here once so that a wrong one is refused before anything moves.
    folder : the recordings.
    job : file with what the process has to do.
    hear : is called with each message, from a thread of its own.
    nice : priority of the process.

    Raises
    ------
    ConfigurationError
        The model is wrong or not there.
    """

    def __init__(
        self, model: Path, folder: Path, job: Path, hear: Callable[[Message], None], nice: int = LOWEST
    ) -> None:
        require_model(model)
        self._hear = hear
        self.last: Message = {}
        job.parent.mkdir(parents=True, exist_ok=True)
        job.write_text(json.dumps(asdict(Job(str(folder.absolute()), str(model.absolute()), nice))), encoding="utf-8")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "bench.twin.process", str(job)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            # Ctrl-C is for the run; the twin ends when the run has
            start_new_session=True,
        )
        self._thread = threading.Thread(target=self._listen, name="twin", daemon=True)
        self._thread.start()

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.poll() is not None

    def finish(self) -> None:
        """Have it look at what is left and end; returns at once."""
        assert self._process.stdin is not None
        if not self._process.stdin.closed:
            self._process.stdin.close()

    def wait(self, seconds: float) -> bool:
        """Wait until it has looked at everything; False where it has not by then."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def kill(self) -> None:
        """End it at once."""
        self.finish()
        self._process.kill()
        self._thread.join(KILL_S)

    def _listen(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                try:
                    message = json.loads(line)
                except ValueError:
                    continue  # what a library printed is no message
                self.last = message
                self._hear(message)
        code = self._process.wait()
        if self.last.get("type") != "ended":
            self._hear({"type": "ended", "why": f"the twin's process ended with exit code {code}"})
