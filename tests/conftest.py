"""Fixtures of more than one folder, and what may not be skipped."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests import units
from tests.veth import VethPair, veth_pair

REQUIRE_WIRE = "BENCH_REQUIRE_WIRE"
"""Environment variable: ``1`` turns a test that skips for want of raw sockets or veth pairs into a failure."""

WIRE_REASONS = ("raw sockets", "veth pair")

SLOW = (
    # a browser, a service, a bench on frames, or a whole campaign
    "tests/browser/",
    "tests/system/",
    "tests/drivers/test_wire.py",
    "tests/fakes/ethercat/wire/",
    "tests/bench/campaigns/test_directions.py",
    "tests/bench/matrix/",
    "tests/bench/service/",
    "tests/bench/twin/test_service.py",
    # a program of its own for each test
    "tests/bench/cli/",
    "tests/docs/test_commands.py::test_short_commands_run",
    "tests/docs/test_notebook.py",
    "tests/docs/test_your_data.py",
    # a whole analysis
    "tests/bench/identification/test_coverage.py",
    "tests/bench/identification/test_orders.py",
    "tests/bench/identification/test_outlook.py",
    "tests/bench/investigate/",
    "tests/bench/mismatch/test_cuts.py",
    "tests/bench/mismatch/test_end_to_end.py",
    "tests/bench/mismatch/test_leave_one_out.py",
    "tests/bench/mismatch/test_linear_axis.py",
    "tests/bench/mismatch/test_many.py",
    "tests/bench/mismatch/test_thinning.py",
    "tests/bench/mismatch/test_together.py",
    "tests/bench/proof/test_analyse.py",
    "tests/bench/proof/test_peers.py",
    "tests/bench/proof/through/",
    "tests/bench/trend/test_trend.py",
    "tests/bench/twin/test_comparison.py",
    "tests/bench/twin/test_cost.py",
    "tests/bench/twin/test_predicting.py",
    "tests/bench/twin/test_watch.py",
    # a whole search of a channel for each test, or a statistic over many
    "tests/bench/foreign/test_mismatch.py",
    "tests/bench/identification/test_fractions.py",
    "tests/bench/mismatch/orders/test_beside_a_mode.py",
    "tests/bench/mismatch/orders/test_defects.py",
    "tests/bench/mismatch/orders/test_laws.py",
    "tests/bench/mismatch/orders/test_misleading_offset.py",
    "tests/bench/mismatch/orders/test_modes.py::test_a_mode_is_found_with_its_numbers",
    "tests/bench/mismatch/orders/test_modes.py::test_where_the_orders_pass_no_mode_nothing_is_gained",
    "tests/bench/mismatch/orders/test_series.py::test_many_orders_that_hardly_change_do_not_still_those_of_the_teeth",
    "tests/bench/mismatch/orders/test_slow_parts.py",
    "tests/bench/mismatch/regression/test_auxiliary.py",
    "tests/bench/mismatch/regression/test_cycles.py::test_a_search_tells_it_without_a_name",
    "tests/bench/mismatch/regression/test_cycles.py::test_noise_has_none",
    "tests/bench/mismatch/regression/test_finer.py::test_what_is_sharper_than_a_coarse_table_gets_a_finer_one",
    "tests/bench/mismatch/regression/test_free_motion.py::test_drag_that_no_name_fits_is_not_two_of_one_name_against_each_other",
    "tests/bench/mismatch/regression/test_gain_over_temperature.py",
    "tests/bench/mismatch/regression/test_hidden_states.py",
    "tests/bench/mismatch/regression/test_knee_over_temperature.py",
    "tests/bench/mismatch/regression/test_next_best.py",
    "tests/bench/mismatch/regression/test_one_law.py",
    "tests/bench/mismatch/regression/test_one_way.py",
    "tests/bench/mismatch/regression/test_open_forms.py",
    "tests/bench/mismatch/regression/test_products_over_angle.py",
    "tests/bench/mismatch/regression/test_same_course.py::test_a_steep_function_of_a_temperature_that_only_rises_may_be_one_of_the_time",
    "tests/bench/mismatch/regression/test_same_course.py::test_lost_motion_at_noisy_speeds_and_temperatures_is_no_function_of_these",
    "tests/bench/mismatch/regression/test_scan.py::test_false_alarms_in_noise_are_as_rare_as_asked",
    "tests/bench/mismatch/regression/test_search.py",
    "tests/bench/mismatch/regression/test_shifted_reading.py",
    "tests/bench/mismatch/regression/test_step_between_stages.py",
    "tests/bench/mismatch/regression/test_stribeck_over_temperature.py",
    "tests/bench/mismatch/report/test_smallest.py",
    "tests/bench/mismatch/test_constant_speed.py",
    "tests/bench/mismatch/test_who_reads_wrong.py",
    "tests/bench/mismatch/unnamed/test_formula.py",
    "tests/bench/mismatch/unnamed/test_ring_down.py::test_in_noise_a_chance_is_as_rare_as_it_says",
    "tests/bench/mismatch/unnamed/test_steps.py::test_noise_of_any_spectrum_has_none",
    "tests/bench/mismatch/unnamed/test_telegraph.py",
    "tests/bench/mismatch/unnamed/test_tone_frequency.py::test_a_line_in_three_recordings_is_as_uncertain_as_three_tell",
    "tests/bench/mismatch/unnamed/test_tone_frequency.py::test_the_interval_holds_the_frequency_as_often_as_it_says",
    "tests/bench/mismatch/unnamed/test_tones.py::test_frequency_and_amplitude_are_as_uncertain_as_they_scatter",
    "tests/bench/mismatch/unnamed/test_tones.py::test_where_orders_cover_a_part_a_chance_in_noise_is_as_rare_as_it_says",
    "tests/bench/twin/test_evidence.py::test_false_alarms_stay_below_the_bound_on_dependent_heavy_tailed_numbers",
    "tests/fakes/concealed/test_folder.py::test_what_the_recordings_tell_apart_is_to_be_named",
    # a file of every kind, spoiled
    "tests/bench/fuzzing/test_fuzz.py::test_few_of_each_kind_are_never_believed_wrongly",
    # every kind of hidden physics
    "tests/fakes/concealed/test_clutter.py",
    "tests/fakes/plant/test_hidden.py",
)
"""Where the tests marked ``slow`` are: the beginnings of their names."""

# Started in the background of a shell, this process ignores Ctrl-C, and so would every program that tests send one to.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The tests start our programs hundreds of times: what Python compiles is kept beside what numba compiles, even where
# the environment asks for none of it.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# As the program itself does: matrices here are small, and threads that wait for each other keep both processors busy.
# Read when NumPy is first imported, which no plugin does before.
for _threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

RAM = Path("/dev/shm")
ROOM_BYTES = 4 << 30
# Nothing that a test writes has to outlive the computer: where there is room in its memory, no test waits for a disk.
if "TMPDIR" not in os.environ and os.access(RAM, os.W_OK) and shutil.disk_usage(RAM).free >= ROOM_BYTES:
    os.environ["TMPDIR"] = tempfile.tempdir = str(RAM)

# Until all tests are collected nothing becomes garbage, and looking for it takes an eighth of the time.
gc.disable()

# The first example of a test may compile a numeric loop; how long that takes says nothing about the code.
settings.register_profile("bench", deadline=None)
settings.load_profile("bench")


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--fmus``: where the Reference FMUs of the FMI project are."""
    parser.addoption("--fmus", help="folder of the Reference FMUs, for their compatibility test")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark the tests of :data:`SLOW`, so that ``-m "not slow"`` leaves them out; sort them for several processes."""
    for item in items:
        if item.nodeid.startswith(SLOW):
            item.add_marker(pytest.mark.slow)
    if hasattr(config, "workerinput"):
        units.first_things_first(items)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Where slow tests are left out, do not even import the files that hold nothing else."""
    if config.getoption("markexpr") != "not slow" or not collection_path.is_relative_to(config.rootpath):
        return None
    place = collection_path.relative_to(config.rootpath).as_posix() + "/" * collection_path.is_dir()
    return True if place.startswith(SLOW) else None


def pytest_collection_finish() -> None:
    """Look for garbage from here on, and not among what was imported and collected, which stays."""
    gc.freeze()
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Hand out the tests as :mod:`tests.units` says, unless ``--dist`` asks for something else."""
    return units.scheduler(config, log) if config.getoption("dist") == "load" else None


@pytest.fixture(scope="session", autouse=True)
def _own_locks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Tests neither join a service that somebody runs on this computer nor lock its bus."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BENCH_RUNTIME", str(tmp_path_factory.mktemp("locks")))
        # a stop of a test is no stop of this computer's bench
        patch.setenv("BENCH_MACHINE", str(tmp_path_factory.mktemp("machine")))
        yield


@pytest.fixture(scope="session")
def veth() -> Iterator[VethPair]:
    """A veth pair that lives as long as the test session; skips where none can be made."""
    with veth_pair() as pair:
        yield pair


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fail what would be skipped for want of a wire, where the environment promises one."""
    report = yield
    if (
        report.skipped
        and os.environ.get(REQUIRE_WIRE) == "1"
        and any(word in report.longreprtext for word in WIRE_REASONS)
    ):
        report.outcome = "failed"
        report.longrepr = f"{item.nodeid} must not be skipped here ({REQUIRE_WIRE}=1): {report.longreprtext}"
    return report
