"""Motion by hand: slow, without load, at low torque, and only as long as somebody holds it (hold-to-run).

Nothing is recorded and no zero is measured: it is for turning the gearbox to where somebody can reach it. It takes the
same way to the drives as a run, with the same limits, latch and stop ladder; two limits are lower.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from bench.campaigns.listener import Tap, Tapped
from bench.campaigns.operator.gentle import gentle, greatest_speed
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.planning.soundness import check_phases
from bench.commissioning import require_commissioned
from bench.commissioning.zero import require_zero
from bench.configuration import BenchConfiguration, BenchFile
from bench.cycle.end import End, EndKind
from bench.cycle.precedence import precedence
from bench.cycle.rig import Rig
from bench.cycle.sink import NoSink, Sink
from bench.errors import LimitError
from bench.protocols import Point
from bench.safety import Cause
from bench.safety.acts import latch_of, require_resumable
from bench.safety.torque_mark import torque_mark
from bench.stop_button import StopButton

_LATE_LOOKS = 5
"""Looks at the bench without torque that a word of who holds it may be late at the beginning."""
_REVOLUTIONS = 1.0
"""Of the load side: it ends there, whoever still holds it."""


def jog(
    file: BenchFile,
    folder: Path,
    velocity: float,
    held: Callable[[], bool],
    button: StopButton,
    *,
    noticed: Callable[[str], None] = lambda _: None,
    tap: Tap | None = None,
    moving: Callable[[], None] = lambda: None,
    seed: int = 0,
    real_time: bool = True,
) -> End:
    """Turn the load side at ``velocity`` (rad/s) while ``held()`` is true, one revolution at most; return how it ended.

    It is asked at every block of cycles and before there is torque; let go, the bench is brought to rest and the
    voltage is taken off, which is the end ``INTERRUPTED`` without a cause. ``folder`` is where an emulated bench keeps
    its latch; ``tap`` sees every row, ``moving`` is called when the motion begins.

    Raises
    ------
    LimitError
        If it is too fast, or the bench was stopped and not resumed; nothing has moved.
    DeviceError
        If the bench cannot be opened or a drive does not follow.
    """
    _require_slow(velocity, file.configuration)
    latch = latch_of(file, folder)
    require_resumable(latch, False, folder if file.configuration.bus.in_process else None)
    commissioned = require_commissioned(file.configuration)
    zero = None if commissioned is None else commissioned.zero
    low = gentle(file)
    with (
        torque_mark(file.configuration, "motion by hand", noticed),
        precedence(file.configuration.bus.master != "emulated") as refused,
        Rig(low, seed=seed, real_time=real_time, latch=latch, zero=zero) as rig,
    ):
        rig.report_stops_to(button.stopped)
        if tap is not None:
            tap.opened(rig)
        if zero is not None:
            require_zero(rig, zero)
        for note in filter(None, (*rig.notes, refused)):
            noticed(note)
        point = Point("constant_velocity", velocity=velocity, options=(("revolutions", _REVOLUTIONS),))
        phases = check_phases(
            build_sequence(point.sequence, point.options).phases(point, facts(low.configuration)),
            low.configuration,
            "motion by hand",
        )
        if not _is_held(rig, held, button):
            return End(EndKind.INTERRUPTED, "let go before it began; nothing has moved", Cause.OPERATOR)
        rig.enable()
        moving()
        sink: Sink = NoSink()
        if tap is not None:
            tap.begin(rig.scaling, rig.now, "by hand")
            sink = Tapped(sink, tap, noticed)
        return rig.run(phases, sink, lambda: button.is_pressed or not held(), "motion by hand")


def _is_held(rig: Rig, held: Callable[[], bool], button: StopButton) -> bool:
    """Whether the button is held, now that the drives could be given torque; a word may be a moment late."""
    for _ in range(_LATE_LOOKS):
        if button.is_pressed:
            return False
        if held():
            return True
        # the bus is led on without torque meanwhile
        rig.look()
    return False


def _require_slow(velocity: float, bench: BenchConfiguration) -> None:
    most = greatest_speed(bench)
    if not math.isfinite(velocity) or velocity == 0.0 or abs(velocity) > most * (1.0 + 1e-9):
        raise LimitError(
            f"motion by hand is asked for at {math.degrees(velocity):.3g} °/s; it should be between 0 and"
            f" {math.degrees(most):.3g} °/s of the load side, either way"
        )
