"""Held-out points: those that the others spare."""

from __future__ import annotations

from bench.mismatch.recordings.split import _leverage, _spread

FORWARD = [("constant_velocity", load, 0.1, 8.0, -1) for load in (-900.0, -500.0, 0.0, 500.0, 900.0)]
BACK = [
    ("constant_velocity", load, -speed, heat, -1)
    for load in (-900.0, -450.0, 0.0, 450.0, 900.0)
    for speed in (0.05, 0.1, 0.17)
    for heat in (6.0, 8.0, 11.0)
]


def test_a_direction_with_few_points_keeps_them() -> None:
    """Five points one way and forty-five the other, in turn: a fifth is held out, of the many."""
    members = [p for k, p in enumerate(BACK) for p in ([p, FORWARD[k // 9]] if k % 9 == 4 else [p])]
    held = _spread(members, 10)
    assert len(set(held)) == 10
    assert sum(p[2] > 0 for p in held) <= 1


def test_a_point_without_a_like_speaks_for_itself_alone() -> None:
    """The only hot point is not spared."""
    hot = ("constant_velocity", 0.0, -0.1, 30.0, -1)
    alone = _leverage([*BACK, hot])
    assert alone[hot] > 2.0 * max(alone[p] for p in BACK)
    assert hot not in _spread([*BACK, hot], 6)
