"""Files the service keeps over a restart: one that cannot be read is put aside, said, and the service begins anew."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

Value = TypeVar("Value")


class Broken:
    """Sentences about files that were put aside; the service says them when it begins."""

    def __init__(self) -> None:
        self.sentences: list[str] = []

    def load(self, path: Path, parse: Callable[[Any], Value]) -> Value | None:
        """Return what ``parse`` makes of a JSON file; None if there is none or it is broken, which is then aside."""
        try:
            return parse(json.loads(path.read_text("utf-8")))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            aside = path.with_name(f"{path.name}.broken-{datetime.now():%Y%m%dT%H%M%S}")
            try:
                path.rename(aside)
                kept = f"it is kept as {aside.name}"
            except OSError as why:
                kept = f"it could not be put aside ({why.strerror})"
            self.sentences.append(f"{path} cannot be read ({type(error).__name__}: {str(error)[:120]}); {kept}")
            return None


def is_there(path: Path) -> bool:
    """Whether a file is there; one nobody can look for counts as there."""
    try:
        return path.exists()
    except OSError:
        return True
