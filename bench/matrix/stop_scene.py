"""What is broken, and how STOP is pressed: the two tables whose every pair is a row of ``docs/stop-times.md``."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
import time
import urllib.request
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from bench.matrix.disks import Disk
from bench.matrix.processes import COMMAND

_ANSWER_S = 8.0
SHELL_S = 60.0
"""Patience with an answer of the service, and with ``bench stop``."""


@dataclass(slots=True)
class Scene:
    """What a condition can break."""

    service: subprocess.Popen[str]
    address: str
    run: int
    folder: Path
    disk: Disk
    mend: list[Callable[[], None]] = field(default_factory=list)


def _service_dead(scene: Scene) -> None:
    scene.service.kill()
    scene.service.wait()


def _service_hung(scene: Scene) -> None:
    scene.service.send_signal(signal.SIGSTOP)
    scene.mend.append(lambda: scene.service.send_signal(signal.SIGCONT))


def _folder_gone(scene: Scene) -> None:
    kept = scene.folder / ".service"
    away = scene.folder.parent / "away"
    kept.rename(away)
    # something else in its place, so that it cannot come back by itself
    kept.touch()

    def bring_back() -> None:
        kept.unlink()
        away.rename(kept)

    scene.mend.append(bring_back)


def _run_hung(scene: Scene) -> None:
    os.kill(scene.run, signal.SIGSTOP)

    def go_on() -> None:
        with suppress(ProcessLookupError):
            os.kill(scene.run, signal.SIGCONT)

    scene.mend.append(go_on)


def _disk_broken(scene: Scene) -> None:
    scene.disk.break_()
    scene.mend.append(scene.disk.mend)


CONDITIONS: dict[str, tuple[str, Callable[[Scene], None]]] = {
    "all is well": ("", lambda scene: None),
    "service dead": ("", _service_dead),
    "service hung": ("", _service_hung),
    "service's folder gone": ("", _folder_gone),
    "run hung": ("", _run_hung),
    "disk full": ("full", _disk_broken),
    "disk read-only": ("read-only", _disk_broken),
    "disk frozen": ("frozen", _disk_broken),
}
"""By name: the disk it needs, and how it is made."""


def _as_a_page(scene: Scene, by: str, port: int | None) -> str:
    """Press as the page does: the service and the run's own listener at once; return who answered what."""
    answers: list[str] = []
    begin, at_ns = time.monotonic(), time.time_ns()
    body = json.dumps({"by": by, "pressed_at_ns": at_ns}).encode()
    ways = {"service": urllib.request.Request(f"{scene.address}/api/stop", body, {"Content-Type": "application/json"})}
    if port is not None:
        url = f"http://127.0.0.1:{port}/stop?by={by}&pressed_at_ns={at_ns}"
        ways["listener"] = urllib.request.Request(url, b"", method="POST")

    def ask(name: str, request: urllib.request.Request) -> None:
        try:
            with urllib.request.urlopen(request, timeout=_ANSWER_S) as answer:
                answer.read()
            answers.append(f"{name} after {time.monotonic() - begin:.2f} s")
        except OSError:
            answers.append(f"no answer of the {name}")

    threads = [threading.Thread(target=ask, args=way, daemon=True) for way in ways.items()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return ", ".join(sorted(answers))


def _in_a_shell(scene: Scene, by: str, port: int | None) -> str:
    try:
        done = subprocess.run(
            [*COMMAND, "stop", "--by", by], capture_output=True, text=True, timeout=SHELL_S, check=False
        )
    except subprocess.TimeoutExpired:
        return f"bench stop had not ended after {SHELL_S:.0f} s"
    return " ".join(done.stdout.split()[-40:]) or done.stderr.strip()[-200:]


PRESSES: dict[str, Callable[[Scene, str, int | None], str]] = {
    "page": _as_a_page,
    "second browser": _as_a_page,
    "shell": _in_a_shell,
}
