"""Hooks of mkdocs: pages that lie outside of docs/, and the reference, made of the docstrings of public modules."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
OUTSIDE = {"README.md": "overview.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Files of the root, and the page each becomes (docs/index.md is the first page)."""
REFERENCE: dict[str, tuple[str, tuple[str, ...]]] = {
    "api": ("Scripts", ("bench.api",)),
    "campaigns": (
        "Campaigns",
        ("bench.campaigns.planning.definition", "bench.campaigns.planning.file", "bench.campaigns.planning.plan"),
    ),
    "configuration": ("Bench files", ("bench.configuration.loading", "bench.configuration.quantities")),
    "recording": (
        "Recordings",
        (
            "bench.recording.reader",
            "bench.recording.folder",
            "bench.recording.header",
            "bench.recording.one_shot",
            "bench.recording.writing.writer",
        ),
    ),
    "identification": ("Identification", ("bench.identification.identify", "bench.identification.summary")),
    "mismatch": ("Mismatch", ("bench.mismatch.run", "bench.mismatch.report.report")),
    "simulation": ("Simulation files", ("bench.simulation.model", "bench.simulation.fourier")),
    "protocols": ("What a sequence is", ("bench.protocols",)),
    "devices": (
        "What a device is",
        ("bench.devices.bus", "bench.devices.masters", "bench.devices.slaves", "bench.devices.thermometers"),
    ),
    "sequences": (
        "Sequences",
        (
            "sequences.constant_velocity",
            "sequences.validation",
            "sequences.thermal",
            "sequences.transients",
            "sequences.tare",
        ),
    ),
    "errors": ("Errors", ("bench.errors",)),
}
"""Pages of the reference: title and modules."""
_LINK = re.compile(r"(?<=\]\()(?!https?:|mailto:|#)([^)#\s]+)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the root and of the reference."""
    for name, page in OUTSIDE.items():
        files.append(File.generated(config, page, content=(ROOT / name).read_text("utf-8")))
    for name, (title, modules) in REFERENCE.items():
        parts = (f"::: {module}\n" for module in modules)
        files.append(File.generated(config, f"reference/{name}.md", content="\n".join((f"# {title}\n", *parts))))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between the root and docs/ into links of the site, where all pages lie in one folder."""
    source = page.file.src_uri
    outside = {page: name for name, page in OUTSIDE.items()}
    folder = posixpath.dirname(outside.get(source, f"docs/{source}"))

    def moved(found: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(folder, found[1]))
        if target in OUTSIDE:
            target = OUTSIDE[target]
        elif target.startswith("docs/"):
            target = target.removeprefix("docs/")
        else:
            return found[1]
        return posixpath.relpath(target, posixpath.dirname(source) or ".")

    return _LINK.sub(moved, markdown)
