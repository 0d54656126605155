"""How large an effect is where it acts: not diluted by the samples in which it does nothing."""

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.regression.strength import active_size


def test_the_samples_without_it_do_not_count() -> None:
    values, number = np.zeros(1000), np.ones(1000)
    values[:100] = 3.0
    assert active_size(values, number) == pytest.approx(3.0, rel=0.05)
    assert active_size(np.tile(3.0, 1000), number) == pytest.approx(3.0, rel=0.05)


def test_a_single_sample_is_spread_over_the_least_share_of_all() -> None:
    values, number = np.zeros(1000), np.ones(1000)
    values[7] = 10.0
    assert active_size(values, number) == pytest.approx(10.0 / np.sqrt(1000 * criteria.LEAST_ACTIVE))
    assert active_size(np.zeros(1000), number) == 0.0
