"""The files between the service and a run process: the job it is given, and the outcome it leaves."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

from bench.service.process.job import Job
from bench.service.runs.runs import Run


def write_job(run: Run, folder: Path, socket: Path, stop_port: int, plant: str | None = None) -> Path:
    """Write what a run process is to do into ``folder`` and return the file; ``stop_port`` is of its stop listener.

    ``plant`` plays an emulated bench in place of the plant its file names.
    """
    folder.mkdir(parents=True, exist_ok=True)
    job = Job(
        run=run.id,
        campaign=run.campaign,
        bench=run.bench,
        folder=run.folder,
        socket=str(socket),
        outcome=str(folder / "outcome.json"),
        interface=run.interface,
        real_time=run.real_time,
        seed=run.seed,
        resumed_by=run.by if run.resumes else None,
        reset_by=run.by if run.resets else None,
        by_hand=run.by_hand,
        tares=run.tares,
        plant=plant,
        not_before=run.not_before,
        stop_port=stop_port,
    )
    path = folder / "job.json"
    path.write_text(json.dumps(job.as_dict()), encoding="utf-8")
    return path


def outcome(folder: Path, code: int | None) -> dict[str, Any]:
    """Return how a run ended that nobody heard the end of; ``code`` is its exit code, None where it is not known."""
    path = folder / "outcome.json"
    try:
        left = json.loads(path.read_text("utf-8"))
        if isinstance(left, dict) and isinstance(left.get("kind"), str) and isinstance(left.get("text"), str):
            return left
        unread = f"{path} holds no outcome"
    except FileNotFoundError:
        unread = ""
    except (OSError, ValueError) as error:
        unread = f"{path} cannot be read: {error}"
    if code == -signal.SIGTERM:
        # ended by STOP before it could take the signal in order: the bench was not open yet
        text = "stopped before it began" + (f"; {unread}" if unread else "")
        return {"kind": "interrupted", "cause": "OPERATOR", "text": text}
    known = "exit code unknown" if code is None else f"exit code {code}"
    text = f"the process of the run ended without a word ({known}{'; ' * bool(unread)}{unread})"
    return {"kind": "died", "cause": "DIED", "text": text}
