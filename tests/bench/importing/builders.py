"""Small measurements of a made-up machine, as text files, and mappings for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bench.importing import Imported, import_recordings
from bench.recording import Rejected


def csv(path: Path, **columns: ArrayLike) -> Path:
    """Write columns under their names, with semicolons between."""
    separator = ";"
    arrays = [np.asarray(values) for values in columns.values()]
    lines = [separator.join(columns)]
    lines += [separator.join(str(value) for value in row) for row in zip(*(a.tolist() for a in arrays), strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


MAPPING = """
campaign_id = "c"
{top}
[gearbox]
ratio = {ratio}
[channels]
time = {{variable = "t", unit = "s"}}
{channels}
[aux]
{aux}
[[recordings]]
file = "{file}"
{entry}
"""


def run(folder: Path, channels: str, **parts: Any) -> list[Imported | Rejected]:
    """Import ``a.csv`` of a folder (or what ``file`` names) with these lines of a mapping."""
    values = {"top": "", "ratio": "1.0", "aux": "", "entry": "", "file": "a.csv"} | parts
    changes = values.pop("changes", None)
    common = 'time = {{variable = "t", unit = "s"}}\n'
    text = MAPPING.replace(common, "") if channels.lstrip().startswith("time = ") else MAPPING
    (folder / "map.toml").write_text(text.format(channels=channels, **values), encoding="utf-8")
    return list(import_recordings(folder / "map.toml", folder / "out", changes=changes))


def one(folder: Path, channels: str, **parts: Any) -> Imported:
    """The same where one recording comes of it."""
    (done,) = run(folder, channels, **parts)
    assert isinstance(done, Imported), done
    return done


def why(folder: Path, channels: str, **parts: Any) -> str:
    """The same where the file is refused: the sentence."""
    (done,) = run(folder, channels, **parts)
    assert isinstance(done, Rejected), done
    return done.why
