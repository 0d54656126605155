"""What the rows of the matrix hold taken together: one paragraph that says no more than they do."""

from __future__ import annotations

from collections.abc import Sequence

from bench.matrix.outcome import Outcome
from bench.matrix.rows import ROWS

_RAMP = "controlled ramp"


def share(outcomes: Sequence[Outcome]) -> str:
    """How many rows are right."""
    right = sum(outcome.passed for outcome in outcomes)
    return f"{right} of {len(outcomes)} rows are as expected."


def summary(outcomes: Sequence[Outcome]) -> str:
    """Rows right, injected under load, judged, and the longest times to rest."""
    loaded = sum(outcome.under_load is True for outcome in outcomes)
    unseen = sum(outcome.under_load is None for outcome in outcomes)
    judged = [outcome.sampled_s for outcome in outcomes if outcome.sampled_s is not None and outcome.peaks is not None]
    finest = min(judged, default=0.0)
    coarse = sum(sampled > finest for sampled in judged)
    widest_ms, finest_ms = 1e3 * max(judged, default=0.0), 1e3 * finest
    apart = f"in {coarse} of them on samples up to {widest_ms:.3g} ms apart, else {finest_ms:.3g} ms"
    fineness = f" ({apart})" if coarse else ""
    sentences = [
        f"{len(outcomes)} of {len(ROWS)} faults were injected with this version of the matrix.",
        share(outcomes),
        f"At the injection the bench moved under load in {loaded} rows "
        f"and did not in {len(outcomes) - loaded - unseen}; in {unseen} this was not observed.",
        f"The true shafts were judged against their envelope in {len(judged)} rows{fineness}, "
        f"not judged in {len(outcomes) - len(judged)}.",
        *_longest(outcomes, ramp=False),
        *_longest(outcomes, ramp=True),
    ]
    return " ".join(sentences)


def sources(outcomes: Sequence[Outcome]) -> str:
    """From which commit and day the rows are; rows of an older run, and rows that were not run, are named."""
    made = list(dict.fromkeys((outcome.day, outcome.commit) for outcome in outcomes))
    if not made:
        return "No row was run."
    newest = max(made, key=lambda key: (key[0], sum((o.day, o.commit) == key for o in outcomes)))
    day, commit = newest
    text = f"Rows are of {day or 'an unknown day'}, commit {commit or 'unknown'}"
    for key in (key for key in made if key != newest):
        names = ", ".join(f"`{outcome.name}`" for outcome in outcomes if (outcome.day, outcome.commit) == key)
        text += f"; of {key[0] or 'an unknown day'}, commit {key[1] or 'unknown'}: {names}"
    known = {(outcome.name, outcome.text) for outcome in outcomes}
    missing = [f"`{row.name}`" for row in ROWS if (row.name, row.text) not in known]
    return text + "." + (f" Not run: {', '.join(missing)}." if missing else "")


def _longest(outcomes: Sequence[Outcome], ramp: bool) -> list[str]:
    rows = [o for o in outcomes if o.stopped_s is not None and (_RAMP in o.rungs) == ramp]
    if not rows:
        return []
    slowest = max(rows, key=lambda outcome: outcome.stopped_s or 0.0)
    how = "after a controlled ramp" if ramp else "without a ramp"
    return [
        f"Longest time from the injection to rest without torque {how}: {slowest.stopped_s:.2f} s (`{slowest.name}`)."
    ]
