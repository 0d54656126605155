"""Press the button of a run from outside: its socket, then signals, then its bus process; and say what was seen."""

from __future__ import annotations

import json
import os
import signal
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar
from urllib.parse import quote

from bench.stop_button.find import Found, bus_processes, is_alive
from bench.stop_button.rest import rest_text

ANSWER_S = 1.0
"""Longest wait for a listener; a run that does not answer by then receives signals."""
_AGAIN_S = 0.05
T = TypeVar("T")
USE_THE_EMERGENCY_STOP = "use the emergency stop"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a press: whether both shafts were seen at rest, and the sentence for whoever pressed."""

    at_rest: bool
    text: str


def stop(found: Found, by: str, patience_s: float, say: Callable[[str], None] = lambda _: None) -> Outcome:
    """Stop one run and watch until it is at rest, ``patience_s`` at most; ``say`` is called with each step."""
    pressed, at_ns = time.monotonic(), time.time_ns()
    what = f"the run of process {found.pid}"
    state = _press(found, by, at_ns)
    if state is None:
        say(f"{what} does not answer; it gets a signal")
        refused = _signal(found.pid)
        if refused is not None:
            return Outcome(False, f"{what} cannot be stopped: {refused}; {USE_THE_EMERGENCY_STOP}")
        state = _until(lambda: _heard(found), ANSWER_S)
        if state is None and is_alive(found.pid):
            return _without_the_run(found, what, pressed, say)
    else:
        say(f"{what} ({state.get('run')}) has received STOP")
    return _wait_for_rest(found, what, pressed, patience_s, state)


def _wait_for_rest(found: Found, what: str, pressed: float, patience_s: float, state: dict[str, Any] | None) -> Outcome:
    """Ask until the run says how its bench is, or has ended."""
    deadline = pressed + patience_s
    while time.monotonic() < deadline:
        state = _ask_state(found) or state
        if state is not None and state.get("state") == "at_rest":
            seen = rest_text(True, state.get("at_rest_after_s"), state.get("bench_to_rest_s"))
            return Outcome(True, f"{what} is at rest: {seen}")
        if not is_alive(found.pid) or (state is not None and state.get("state") == "not_seen"):
            gone = time.monotonic() - pressed
            return Outcome(
                False, f"{what} has ended its stop {gone:.2f} s after the press, and nobody saw the shafts at rest"
            )
        time.sleep(_AGAIN_S)
    return Outcome(False, f"{what} was not seen at rest within {patience_s:.0f} s: {USE_THE_EMERGENCY_STOP}")


def _without_the_run(found: Found, what: str, pressed: float, say: Callable[[str], None]) -> Outcome:
    """Have the bus process stop the drives: it does so by itself when it is asked to end."""
    buses = bus_processes(found.pid)
    if not buses:
        return Outcome(False, f"{what} hangs, and nothing else can stop its bench: {USE_THE_EMERGENCY_STOP}")
    say(f"{what} hangs; its bus process gets the order to stop the drives")
    for bus in buses:
        refused = _signal(bus)
        if refused is not None:
            return Outcome(False, f"the bus process {bus} cannot be reached: {refused}; {USE_THE_EMERGENCY_STOP}")
    ended = _until(lambda: not any(is_alive(bus) for bus in buses) or None, 10.0 * ANSWER_S)
    if ended is None:
        return Outcome(False, f"{what} hangs, and its bus process has not ended: {USE_THE_EMERGENCY_STOP}")
    after = f"{time.monotonic() - pressed:.2f} s after the press"
    return Outcome(
        False,
        f"{what} hangs; its bus process stopped the drives and ended {after}; nobody saw the shafts at rest: look at"
        f" the bench, {USE_THE_EMERGENCY_STOP} if they turn",
    )


def _press(found: Found, by: str, at_ns: int) -> dict[str, Any] | None:
    return _answer(found, f"POST /stop?by={quote(by)}&pressed_at_ns={at_ns}")


def _ask_state(found: Found) -> dict[str, Any] | None:
    return _answer(found, "GET /state")


def _heard(found: Found) -> dict[str, Any] | None:
    """Return what the run says if it has heard of a stop."""
    state = _ask_state(found)
    return state if state is not None and state.get("state") != "running" else None


def _answer(found: Found, request: str) -> dict[str, Any] | None:
    """Send a request to each listener of a run; return the last answer, None where none came in time."""
    answer = None
    for name in found.sockets:
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
                connection.settimeout(ANSWER_S)
                connection.connect(f"\0{name}")
                connection.sendall(f"{request} HTTP/1.1\r\n\r\n".encode())
                with connection.makefile("rb") as lines:
                    status, _, body = lines.read(65536).partition(b"\r\n\r\n")
                said = json.loads(body)
        except (OSError, ValueError):
            continue
        if b" 200 " in status.split(b"\r\n", 1)[0] and isinstance(said, dict):
            answer = said
    return answer


def _signal(pid: int) -> str | None:
    """Send SIGTERM; return why that was not possible."""
    try:
        os.kill(pid, signal.SIGTERM)
    except ProcessLookupError:
        return None  # it has ended meanwhile, which is seen next
    except PermissionError:
        return "it belongs to another user"
    return None


def _until(true: Callable[[], T | None], patience_s: float) -> T | None:
    deadline = time.monotonic() + patience_s
    while (answer := true()) is None and time.monotonic() < deadline:
        time.sleep(_AGAIN_S)
    return answer
