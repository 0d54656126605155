"""The tables of an identification as the terminal shows them."""

from __future__ import annotations

from rich.table import Table

from bench.identification.identify import Identification
from bench.identification.summary import SYMBOL_TERMS, doubtful, parameters
from bench.identification.validation import PAPER_TABLE, table

_SIGNS = {"positive": "+", "negative": "−"}
COLUMNS = (("refined", "refined"), ("paper", "paper's method"), ("bound", "bound"))


def error_table(found: Identification) -> Table:
    """RMSE / MAE by set and direction, beside the paper's own figures."""
    title = "Transmission error, mean removed: mean RMSE / mean MAE in µrad"
    # whole even in a terminal of 80 columns
    out = Table(title=title, box=None, padding=(0, 1, 0, 0))
    for heading in ("recordings", "", "no.", *(name for _, name in COLUMNS), "paper's bench"):
        out.add_column(heading, justify="left" if heading == "recordings" else "right", no_wrap=True)
    for kind, rows in table(found.scores).items():
        for direction, models in rows.items():
            cells = [f"{1e6 * models[m]['rmse']:.2f} / {1e6 * models[m]['mae']:.2f}" for m, _ in COLUMNS]
            paper = PAPER_TABLE[kind][direction]
            number = str(int(models["bound"]["recordings"]))
            out.add_row(kind, _SIGNS[direction], number, *cells, f"{1e6 * paper[0]:.1f} / {1e6 * paper[1]:.1f}")
    return out


def parameter_table(found: Identification) -> Table:
    """Parameters of the slow equations with their standard deviations."""
    out = Table(title="Friction, heat balance, load side", box=None, pad_edge=False)
    for heading in ("symbol", "value", "standard deviation", "unit", "term"):
        out.add_column(heading, justify="right" if heading in ("value", "standard deviation") else "left")
    doubts = doubtful(found)
    for symbol, p in parameters(found).items():
        std = "–" if p.std is None else f"{p.std:.2g}"
        if symbol in found.friction.systematic:
            std += f" and {found.friction.systematic[symbol]:.2g} (instant of torque)"
        out.add_row(
            f"{symbol} (!)" if symbol in doubts else symbol, f"{p.value:.5g}", std, p.unit, SYMBOL_TERMS[symbol]
        )
    return out
