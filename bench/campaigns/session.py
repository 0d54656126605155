"""From files to a finished campaign: opens the bench, runs, and turns signals of the operator into a stop at rest."""

from __future__ import annotations

import gc
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from bench.campaigns.acts import latch_of, require_resumable, resume
from bench.campaigns.definition import Campaign
from bench.campaigns.directions import Directions
from bench.campaigns.listener import Listener, Silent, Tap
from bench.campaigns.plan import make_plan
from bench.campaigns.runner import Runner
from bench.campaigns.taken import Summary
from bench.commissioning import require_commissioned
from bench.commissioning.zero import require_zero
from bench.configuration import BenchFile
from bench.cycle.precedence import precedence
from bench.cycle.rig import Rig
from bench.errors import ConfigurationError


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Give an event that Ctrl-C (SIGINT) or SIGTERM sets; outside the main thread signals stay as they are."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def handler(number: int, frame: FrameType | None) -> None:
        stop.set()

    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, old in before.items():
            signal.signal(number, old)


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
) -> Summary:
    """Open the bench, run the campaign into ``folder``, bring the bench to rest.

    ``listener`` is told how it goes, ``directions`` tell it what to do on its way, ``tap`` sees every row; None for
    nobody.
    ``reset_faults`` acknowledges faults the drives show from before; without it such a drive is not enabled.
    ``resumed_by`` is who wants torque again after a stop that was acknowledged and reset; without a name such a bench
    is not run.

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
        stop_on_signals() as stop,
        precedence(file.configuration.bus.master != "emulated") as refused,
        Rig(file, seed=seed, real_time=real_time, latch=latch, zero=zero) as rig,
    ):
        if zero is not None:
            require_zero(rig, zero)
        if reset_faults:
            rig.reset_faults()
        if rig.is_real_time:
            # what is loaded by now stays: the collector need not look at it while cycles are due
            gc.freeze()
        for note in filter(None, (*rig.notes, refused)):
            (listener or Silent()).noticed(note)
        plan = make_plan(campaign, file.configuration, rig.temperature)
        if resumed_by is not None:
            resume(latch, resumed_by)
        return Runner(rig, file, campaign, plan, folder, listener or Silent(), stop.is_set, directions, tap).run()
