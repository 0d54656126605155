from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.identification import Identification
from bench.identification.balances.load_side import ripple_columns
from bench.identification.samples.blocks import make_blocks
from bench.identification.series.ripple import find_ripple, of_pole_pairs
from bench.recording import RecordingFolder
from tests.bench.identification.synthetic import Bench


def test_ripple_is_found_in_the_load_torque(found: Identification) -> None:
    # the synthetic bench ripples at 150 only; the transmission error's orders are in the angle, not in the torque
    assert found.notch_orders == (150,)


def test_no_ripple_is_invented(tmp_path: Path) -> None:
    class Smooth(Bench):
        def _acceleration(self, speed: np.ndarray) -> np.ndarray:
            return np.zeros_like(speed)

    bench = Smooth(tmp_path)
    bench.write(100.0, 0.1, 25.0, kind="validation")
    orders, reason = find_ripple(RecordingFolder.open(tmp_path).recordings)
    assert orders == ()
    assert "no steady recording" in reason


def test_pole_pairs_give_the_orders() -> None:
    assert of_pole_pairs(25) == (150, 300)
    assert of_pole_pairs(11) == (66, 132)


def test_notch_and_pole_pairs_together_are_refused(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        make_app(), ["identify", str(tmp_path), "--notch", "150", "--pole-pairs", "25"], standalone_mode=False
    )
    assert "give one of them" in str(result.exception)


@pytest.mark.parametrize("acceleration", [0.0, 0.216, -0.216])
def test_ripple_columns_are_the_averages_of_the_waves(acceleration: float) -> None:
    rate, order = 2000.0, 150
    t = np.arange(3000) / rate
    angle = 0.3 + 0.17 * t + 0.5 * acceleration * t**2
    channels = {
        "time": t,
        "load_angle": angle,
        "load_torque": np.sin(order * angle),
        "motor_torque": np.cos(order * angle),
    }
    blocks = make_blocks(channels, rate, np.zeros(t.size, dtype=bool), np.empty(0, dtype=np.int64))
    columns = ripple_columns(blocks, (order,))
    assert columns[f"ripple {order} s"] == pytest.approx(blocks.load_torque, abs=4e-3)
    assert columns[f"ripple {order} c"] == pytest.approx(blocks.motor_torque, abs=4e-3)
