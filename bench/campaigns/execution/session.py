"""From files to a finished campaign: opens the bench, runs, and turns signals of the operator into a stop at rest."""

from __future__ import annotations

import gc
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from datetime import datetime
from pathlib import Path
from types import FrameType

from bench.campaigns.execution.runner import Runner
from bench.campaigns.execution.sequence_call import Stopped, call_sequence
from bench.campaigns.listener import Listener, Silent, Tap
from bench.campaigns.operator.directions import Directions
from bench.campaigns.planning.definition import Campaign
from bench.campaigns.planning.plan import make_plan
from bench.campaigns.taken import Summary
from bench.commissioning import require_commissioned
from bench.commissioning.zero import require_zero
from bench.configuration import BenchFile
from bench.cycle.end import End, EndKind
from bench.cycle.precedence import precedence
from bench.cycle.rig import Rig
from bench.errors import ConfigurationError
from bench.safety import Cause
from bench.safety.acts import latch_of, require_resumable, resume
from bench.safety.torque_mark import torque_mark
from bench.stop_button import StopButton, listening

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
"""Ctrl-C, a polite kill, a terminal that closes, Ctrl-\\: each brings the bench to rest."""


@contextmanager
def stop_on_signals(button: StopButton) -> Iterator[None]:
    """Have each of :data:`STOP_SIGNALS` press a button; outside the main thread signals stay as they are."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handler(number: int, frame: FrameType | None) -> None:
        button.press(signal.Signals(number).name)

    before = {number: signal.signal(number, handler) for number in STOP_SIGNALS}
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


@contextmanager
def _pressed_by_others(folder: Path) -> Iterator[StopButton]:
    """Give a button that ``bench stop`` and pages find."""
    button = StopButton(folder.name)
    with listening(button):
        yield button


def run_campaign(
    file: BenchFile,
    campaign: Campaign,
    folder: Path,
    listener: Listener | None = None,
    *,
    seed: int = 0,
    real_time: bool = False,
    reset_faults: bool = False,
    resumed_by: str | None = None,
    directions: Directions | None = None,
    tap: Tap | None = None,
    button: StopButton | None = None,
    not_before: datetime | None = None,
) -> Summary:
    """Open the bench, run the campaign into ``folder``, bring the bench to rest.

    ``listener`` receives how it goes, ``directions`` are the operator's orders on its way, ``tap`` sees every row;
    None for nobody. ``button`` is what stops it, with a listener of its own; None for one that is made here.
    ``reset_faults`` acknowledges faults the drives show from before; without it such a drive is not enabled.
    ``resumed_by`` is who wants torque again after a stop that was acknowledged and reset; without a name such a bench
    is not run. ``not_before``: when an emulated bench in fast time begins at the earliest.

    Raises
    ------
    ConfigurationError
        If the folder is none.
    LimitError
        If the campaign would break a limit from the temperature found, a stop was not resumed, or a bench behind a
        network interface was not commissioned or lost its zero with its power; nothing has moved.
    DeviceError
        If the bench cannot be opened or a drive does not follow.
    """
    if folder.exists() and not folder.is_dir():
        raise ConfigurationError(f"{folder} is a file; recordings go into a folder, give another with --out")
    latch = latch_of(file, folder)
    require_resumable(latch, resumed_by is not None, folder if file.configuration.bus.in_process else None)
    commissioned = require_commissioned(file.configuration)
    zero = None if commissioned is None else commissioned.zero
    with (
        _pressed_by_others(folder) if button is None else nullcontext(button) as button,
        stop_on_signals(button),
        torque_mark(file.configuration, f"{campaign.name} in {folder.name}", (listener or Silent()).noticed),
        precedence(file.configuration.bus.master != "emulated") as refused,
        Rig(file, seed=seed, real_time=real_time, latch=latch, zero=zero, not_before=not_before) as rig,
    ):
        rig.report_stops_to(button.stopped)
        if tap is not None:
            tap.opened(rig)
        if zero is not None:
            require_zero(rig, zero)
        if reset_faults:
            rig.reset_faults()
        if rig.is_real_time:
            # what is loaded by now stays: the collector need not look at it while cycles are due
            gc.freeze()
        for note in filter(None, (*rig.notes, refused)):
            (listener or Silent()).noticed(note)

        def stop_requested() -> bool:
            return button.is_pressed or (directions is not None and directions.stop_requested)

        try:
            plan = call_sequence(
                f"the plan of campaign {campaign.name}",
                lambda: make_plan(campaign, file.configuration, rig.temperature),
                rig,
                stop_requested,
            )
            if resumed_by is not None:
                resume(latch, resumed_by)
            return Runner(
                rig, file, campaign, plan, folder, listener or Silent(), stop_requested, directions, tap
            ).run()
        except Stopped as error:
            # before there was torque: nothing has moved
            return Summary(End(EndKind.INTERRUPTED, str(error), Cause.OPERATOR))
