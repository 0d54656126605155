"""``bench prove --open``: what a seed conceals, shown to whoever has looked for it long enough."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import typer

from bench.cli._plain import say
from bench.configuration import load_bench
from bench.errors import ProofError
from bench.proof.seal import opened, unbroken


def print_concealed(bench: str, seed: int, folder: Path | None, as_json: bool) -> None:
    """Print what the seed conceals in the bench's plant, and its hash.

    Raises
    ------
    ProofError
        The recordings in ``folder`` have no seal, or another.
    """
    content, digest = opened(load_bench(bench), seed)
    if folder is not None and not unbroken(folder, digest):
        raise ProofError(
            f"{folder} is sealed with another hash than seed {seed} of {bench} has: it is not of this seed."
        )
    if as_json:
        typer.echo(json.dumps({**content, "sha256": digest}, ensure_ascii=False))
        return
    say(f"seal {digest}")
    for row in content["concealed"]:
        say(f"  {row['effect']}: {row['form']}, most in {row['channel']} ({_numbers(row['parameters'])})")
    if not content["concealed"]:
        say("  nothing beyond the nominal equations")
    if content["weak_orders"]:
        orders = ", ".join(f"{order:g}" for order in content["weak_orders"])
        say(f"  te.harmonic: {len(content['weak_orders'])} weak orders of the gearbox ({orders})")


def _numbers(parameters: dict[str, Any]) -> str:
    return ", ".join(f"{name} {value:.3g}" for name, value in parameters.items())
