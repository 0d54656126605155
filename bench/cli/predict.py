"""``bench predict``: what a simulation file says of recordings, beside what was measured."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import say
from bench.cli.mismatch import one_thread

if TYPE_CHECKING:
    from bench.exchange.predicted import Channel


class Form(StrEnum):
    """Formats that can be written."""

    H5 = "h5"
    CSV = "csv"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="predict")(predict)


def predict(
    model: Annotated[Path, typer.Argument(help="Simulation file (model.json).", metavar="MODEL")],
    recordings: Annotated[Path, typer.Argument(help="A recording, or a folder of recordings.", metavar="RECORDINGS")],
    out: Annotated[Path, typer.Option("--out", help="Folder the copies go to; it is made if need be.")],
    form: Annotated[Form, typer.Option("--to", help="Recordings (HDF5), or tables.")] = Form.H5,
    plot: Annotated[bool, typer.Option("--plot/--no-plot", help="Draw each recording as well.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print files and root mean squares as JSON.")] = False,
) -> None:
    """Write predicted channels and residuals beside the measured ones, into a copy: a recording is never changed.

    HDF5: the recording with simulated/NAME and residual/NAME in it, which every command reads. CSV: time, and each
    channel as measured, as simulated, and the residual. The command prints what cannot be predicted, and why.
    """
    one_thread()
    from bench.exchange.beside import WRITERS, draw
    from bench.exchange.predicted import predict_recordings

    written = []
    out.mkdir(parents=True, exist_ok=True)
    notes: list[str] = []
    refused: dict[str, list[str]] = {}
    for one in predict_recordings(model, recordings):
        notes += [text for text in (one.unlike, one.open_circuit) if text and text not in notes]
        for sentence in one.refused:
            # recordings of a folder mostly lack the same channels
            refused.setdefault(sentence.replace(one.recording.recording_id, "", 1), []).append(sentence)
        if not one.channels:
            continue
        files = [WRITERS[form.value](one, out)]
        if plot:
            files.append(draw(one, out))
        left = {
            c.name: {"rms": c.rms, "rms_of_all": c.rms_of_all, "compared": c.compared, "unit": c.unit}
            for c in one.channels
        }
        written.append({"recording": one.recording.recording_id, "files": [str(f) for f in files], "residual": left})
        if not as_json:
            say(f"{files[0]}: residual (rms) {', '.join(_said(channel) for channel in one.channels)}")
    if as_json:
        sentences = list(dict.fromkeys(sentence for alike in refused.values() for sentence in alike))
        say(json.dumps({"recordings": written, "refused": sentences, "notes": notes}, ensure_ascii=False))
        return
    for note in notes:
        say(f"note: {note}")
    for first, *others in refused.values():
        say(f"note: {first}{f' (the same in {len(others)} other recordings)' if others else ''}")


def _said(channel: Channel) -> str:
    """Name and residual of a channel; where samples are not compared, how many, and what all of them leave."""
    if channel.rms is None:
        return f"{channel.name} not compared"
    text = f"{channel.name} {channel.rms:.3g} {channel.unit}"
    left_out = channel.counts.size - int(channel.counts.sum())
    if not left_out:
        return text
    beside = f"{left_out} of {channel.counts.size} samples are not compared"
    return f"{text} ({beside}; with them {channel.rms_of_all:.3g} {channel.unit})"
