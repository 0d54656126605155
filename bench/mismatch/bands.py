"""Free functions that act in one place only: a band of speed, load or temperature, a spell of the campaign's time.

A hump at one speed or an hour with another zero is too narrow for the knots of the smooth rivals. So the place itself
is looked for: bands at every centre and in several widths, spells from every recording to every later one, each by the
log-likelihood it gains beside the simulation (and beside what has a name already). The best become rivals, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.bank import Bank
from bench.mismatch.columns import Entry
from bench.mismatch.rivals import QUANTITIES, modulator
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TRANSMISSION_ERROR

CENTRES = 21
WIDTHS = (0.04, 0.06, 0.09)
"""standard deviations of a band, in units of the quantity's range"""
FINER_CENTRES = np.linspace(-0.75, 0.75, 7)
FINER_WIDTHS = (0.7, 0.85, 1.0, 1.2, 1.4)
FEWEST_INSIDE = 3
"""recordings inside a spell, and outside"""
FASTEST = 2.5
"""of the usual speed: where the bench is driven to warm up, there is no band of speeds"""
KEPT = 3
"""places of one search that become rivals"""
TIME = "time"


@dataclass(frozen=True, slots=True)
class Place:
    """A free function with the place where it acts: centre and width of a band, begin and end of a spell (s)."""

    name: str
    quantity: str
    point: tuple[float, float]
    gain: float


# channel -> name: quantity, modulator (see the rivals' table)
_TABLE: dict[str, dict[str, tuple[str, str]]] = {
    MOTOR_TORQUE: {
        "friction in a band of speed": ("speed", "d"),
        "friction in a band of load": ("torque", "d"),
        "torque in a band of load": ("torque", "1"),
        "friction in a band of temperature": ("temperature", "d"),
        "friction in a spell of time": (TIME, "d"),
        "offset in a spell of time": (TIME, "1"),
    },
    LOAD_TORQUE: {
        "torque in a band of speed": ("speed", "1"),
        "friction in a band of speed": ("speed", "d"),
        "torque in a band of load": ("load_motor_torque", "1"),
        "offset in a band of temperature": ("temperature", "1"),
        "offset in a spell of time": (TIME, "1"),
        "friction in a spell of time": (TIME, "d"),
        "gain in a spell of time": (TIME, "tau"),
    },
    TRANSMISSION_ERROR: {
        "offset in a band of speed": ("speed", "1"),
        "offset in a band of load": ("torque", "1"),
        "offset in a band of temperature": ("temperature", "1"),
        "offset in a spell of time": (TIME, "1"),
    },
}


_UNITS = {"speed": "rad/s", TIME: "s", "temperature": "°C"}
_FACTORS = {"1": "", "d": "*d", "tau": "*tau/1000"}


def equation(channel: str, name: str) -> str:
    """The function in words that a report can have: of what, where, times what."""
    quantity, factor = _TABLE[channel][name]
    where = "(begin <= t < end)" if quantity == TIME else f"*exp(-(({quantity} - x_0)/w)**2/2)"
    return f"{channel} += c_0{_FACTORS[factor]}{'*' if quantity == TIME else ''}{where}"


def parameters(channel: str, name: str, point: tuple[float, ...]) -> list[dict[str, Any]]:
    """Where the function acts, as the report has parameters: begin and end, or centre and width of a band."""
    quantity, _ = _TABLE[channel][name]
    unit = _UNITS.get(quantity, "N*m")
    symbols = ("begin", "end") if quantity == TIME else ("x_0", "w")
    return [{"symbol": s, "value": float(v), "unit": unit, "std": 0.0} for s, v in zip(symbols, point, strict=True)]


def slots(channel: str) -> int:
    """Columns to keep free for a channel's places: found beside the simulation, and beside what has a name."""
    return 2 * KEPT if channel in _TABLE else 0


def column(channel: str, name: str, point: tuple[float, ...], frame: Frame) -> FloatArray:
    """The function at the rows of a frame, (n, 1)."""
    quantity, factor = _TABLE[channel][name]
    return (_inside(quantity, QUANTITIES[quantity](frame), point) * modulator(frame, factor))[:, None]


def _inside(quantity: str, values: FloatArray, point: tuple[float, ...]) -> FloatArray:
    if quantity == TIME:
        return np.asarray((values >= point[0]) & (values < point[1]), dtype=np.float64)
    return np.asarray(np.exp(-0.5 * ((values - point[0]) / point[1]) ** 2))


def places(channel: str, frame: Frame, used: NDArray[np.bool_], bank: Bank, index: Sequence[int]) -> list[Place]:
    """The places that gain most beside the columns ``index``, one a kind, strongest first.

    ``frame`` has all rows, ``used`` marks those of the bank.
    """
    out = []
    for name, (quantity, factor) in _TABLE.get(channel, {}).items():
        values, by = QUANTITIES[quantity](frame)[used], modulator(frame, factor)[used]
        search = _spell if quantity == TIME else _band
        point, gain = search(quantity, values, by, bank, index)
        if gain > 0.0:
            out.append(Place(name, quantity, point, gain))
    return sorted(out, key=lambda p: -p.gain)[:KEPT]


def fill(
    channel: str,
    frame: Frame,
    used: NDArray[np.bool_],
    bank: Bank,
    place: Sequence[int],
    models: Sequence[Sequence[int]],
) -> list[Entry]:
    """Search beside each of the ``models`` (columns) and put what is found into the bank's free columns ``place``."""
    out: list[Entry] = []
    free = list(place)
    for index in models:
        for found in places(channel, frame, used, bank, index):
            if free and not any(e.form == found.name and e.point == found.point for e in out):
                own = (free.pop(0),)
                bank.replace(own, column(channel, found.name, found.point, frame)[used])
                out.append(Entry("unknown", found.name, found.point, own, (found.quantity,), (), False))
    return out


def _gains(columns: FloatArray, bank: Bank, index: Sequence[int]) -> FloatArray:
    gram, product = bank.beside(columns, index)
    energy = np.diag(gram)
    return np.asarray(np.where(energy > 1e-6 * energy.max(), 0.5 * product**2 / np.maximum(energy, 1e-300), 0.0))


def _band(
    quantity: str, values: FloatArray, by: FloatArray, bank: Bank, index: Sequence[int]
) -> tuple[tuple[float, float], float]:
    low, high = float(values.min()), float(values.max())
    if quantity == "speed":
        usual = [float(np.median(values[a:b])) for a, b in zip(bank.starts[:-1], bank.starts[1:], strict=True)]
        high = min(high, FASTEST * float(np.median(usual)))
    span = high - low
    if span <= 0.0:
        return (0.0, 1.0), 0.0
    step = span / (CENTRES - 1)
    coarse = [(low + k * step, w * span) for k in range(1, CENTRES - 1) for w in WIDTHS]
    best, _ = _best(coarse, quantity, values, by, bank, index)
    finer = [(best[0] + float(c) * step, best[1] * w) for c in FINER_CENTRES for w in FINER_WIDTHS]
    return _best(finer, quantity, values, by, bank, index)


def _best(
    points: Sequence[tuple[float, float]],
    quantity: str,
    values: FloatArray,
    by: FloatArray,
    bank: Bank,
    index: Sequence[int],
) -> tuple[tuple[float, float], float]:
    gains = _gains(np.column_stack([_inside(quantity, values, p) * by for p in points]), bank, index)
    place = int(np.argmax(gains))
    return points[place], float(gains[place])


def _spell(
    quantity: str, values: FloatArray, by: FloatArray, bank: Bank, index: Sequence[int]
) -> tuple[tuple[float, float], float]:
    """The run of recordings that gains most; sums over runs come from sums over all before."""
    starts = bank.starts
    number = starts.size - 1
    if number < 2 * FEWEST_INSIDE:
        return (0.0, 1.0), 0.0
    own = np.zeros((values.size, number))
    for r in range(number):
        own[starts[r] : starts[r + 1], r] = by[starts[r] : starts[r + 1]]
    gram, product = bank.beside(own, index)
    before = np.append(0.0, np.cumsum(product))
    table = np.zeros((number + 1, number + 1))
    table[1:, 1:] = np.cumsum(np.cumsum(gram, axis=0), axis=1)
    least = 1e-6 * float(np.diag(gram).max())
    best, place = 0.0, (0, number)
    for a, b in _runs(number):
        energy = table[b, b] - table[a, b] - table[b, a] + table[a, a]
        gain = 0.5 * (before[b] - before[a]) ** 2 / energy if energy > least else 0.0
        if gain > best:
            best, place = float(gain), (a, b)
    edges = np.append(-np.inf, 0.5 * (values[starts[1:-1] - 1] + values[starts[1:-1]]))
    edges = np.append(edges, np.inf)
    span = float(np.ptp(values))
    ends = float(values.min()) - span, float(values.max()) + span
    return (float(np.clip(edges[place[0]], *ends)), float(np.clip(edges[place[1]], *ends))), best


def _runs(number: int) -> Iterator[tuple[int, int]]:
    for a in range(number):
        for b in range(a + FEWEST_INSIDE, number + 1):
            if number - (b - a) >= FEWEST_INSIDE:
                yield a, b
