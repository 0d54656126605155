"""Python and the packages the program needs."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Sequence
from importlib import metadata

from packaging.requirements import Requirement

from bench.cycle.doctor.finding import Finding, bad, good

_OLDEST = (3, 11)


def python() -> list[Finding]:
    """Look at the interpreter."""
    if sys.version_info < _OLDEST:
        return [bad("Python", platform.python_version(), f"{_OLDEST[0]}.{_OLDEST[1]} or newer")]
    return [good("Python", platform.python_version())]


def packages(
    requirements: Sequence[str] | None = None, version: Callable[[str], str] = metadata.version
) -> list[Finding]:
    """Compare what is installed with what the program requires (extras left out)."""
    wanted = [
        Requirement(text) for text in (metadata.requires("gearbench") or () if requirements is None else requirements)
    ]
    wanted = [item for item in wanted if item.marker is None or item.marker.evaluate({"extra": ""})]
    found = []
    for item in wanted:
        try:
            installed = version(item.name)
        except metadata.PackageNotFoundError:
            found.append(bad(f"package {item.name}", "not installed", f"pip install '{item}'"))
            continue
        if not item.specifier.contains(installed, prereleases=True):
            found.append(
                bad(f"package {item.name}", f"{installed}, needed is {item.specifier}", f"pip install '{item}'")
            )
    if not found:
        found.append(good("packages", f"{len(wanted)} of {len(wanted)} installed, versions as required"))
    return found
