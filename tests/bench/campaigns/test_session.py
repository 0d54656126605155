import signal

import pytest

from bench.campaigns.execution.session import stop_on_signals
from bench.stop_button import StopButton


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"])
def test_each_signal_that_ends_a_program_stops_the_bench_first(name: str) -> None:
    number, button = signal.Signals[name], StopButton("run")
    before = signal.getsignal(number)
    with stop_on_signals(button):
        assert not button.is_pressed
        signal.raise_signal(number)
        assert button.is_pressed
    assert button.state()["pressed_by"] == name
    assert signal.getsignal(number) is before
