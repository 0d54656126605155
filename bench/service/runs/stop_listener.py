"""Where the run's own stop listener is: the page asks it for a stop beside the service, which may hang."""

from __future__ import annotations

import json
from pathlib import Path

FILE = "stop.json"
"""In the runtime folder, written by the run's process: ``{"pid", "port", "run"}``."""


def stop_port(runtime: Path) -> int | None:
    """Return the port of the listener on 127.0.0.1, None where there is none."""
    try:
        said = json.loads((runtime / FILE).read_text("utf-8"))
        pid, port = int(said["pid"]), int(said["port"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return port if 0 < port < 65536 and Path(f"/proc/{pid}").exists() else None
