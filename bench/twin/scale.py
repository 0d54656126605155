"""The scale of each stream: what the model leaves in the first recordings, with room for not knowing it well.

The mean square of ``m`` numbers estimates E[y²]; it is divided by a low quantile of its own distribution (χ² with m
degrees of freedom over m), so that the scale is too small with a probability of ``share`` only, were the numbers normal
and alike. What is tested afterwards is y over this scale. Nothing is learned any more once the test has begun: a change
cannot teach the twin to take it for noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from bench.twin.streams import DIRECTION, MEAN, OFFSET, ORDER, Stream

CALIBRATION = 16
"""recordings at one point each by which the scales are known"""
LEAST = 12
"""of these, how many have to have a stream for it to be watched"""
LEAST_EACH = 3
"""recordings of one direction for its mean to be known"""
ALPHA = 0.01
"""chance of a false alarm in a campaign, whatever its length"""
ALPHA_SCALES = 0.002
"""of it, spent on the scales"""
ALPHA_TEST = ALPHA - ALPHA_SCALES
"""of it, spent on the test"""


@dataclass(frozen=True, slots=True)
class Scale:
    """How a stream is centred and scaled, in its unit.

    ``centres``: mean residual of each measured stream in the first recordings, which is subtracted; ``size``: divisor.
    ``turned``: a mean is multiplied by the sign of the direction.
    """

    centres: Mapping[Stream, float]
    size: float
    turned: bool = False

    def change(self, values: Mapping[Stream, float]) -> float | None:
        """Difference from the first recordings, in the stream's unit; None where the recording lacks the stream."""
        for measured, centre in self.centres.items():
            if measured in values:
                off = values[measured] - centre
                return off * measured.number if self.turned else off
        return None

    def innovation(self, values: Mapping[Stream, float]) -> float | None:
        """The same, divided by the scale."""
        off = self.change(values)
        return None if off is None else off / self.size


def measured_for(stream: Stream) -> tuple[Stream, ...]:
    """Streams that are measured for a stream; a recording has one of them."""
    if stream.what in (OFFSET, DIRECTION):
        return tuple(Stream(stream.channel, MEAN, side) for side in (1, -1))
    return (stream,)


def scales(first: Sequence[Mapping[Stream, float]], watched: Sequence[Stream]) -> dict[Stream, Scale]:
    """Scales of the streams that enough of the ``first`` recordings have."""
    out = {}
    share = ALPHA_SCALES / max(len(watched), 1)
    for stream in watched:
        groups = {m: [measured[m] for measured in first if m in measured] for m in measured_for(stream)}
        groups = {m: values for m, values in groups.items() if len(values) >= LEAST_EACH}
        number = sum(map(len, groups.values()))
        if number < LEAST:
            continue
        # an amplitude that the model has right is noise about zero; all else is compared with what it was at first
        centres = {m: 0.0 if stream.what == ORDER else float(np.mean(values)) for m, values in groups.items()}
        freedom = number - (0 if stream.what == ORDER else len(groups))
        square = sum(float(np.sum((np.array(values) - centres[m]) ** 2)) for m, values in groups.items())
        if square > 0.0:
            size = float(np.sqrt(square / chi2.ppf(share, freedom)))
            out[stream] = Scale(centres, size, stream.what == DIRECTION)
    return out
