"""How many faults of a file a sentence speaks of: those that its writer made."""

from __future__ import annotations

import pytest

from bench.campaigns.planning.file import parse_campaign
from bench.configuration import load_bench, parse_bench
from bench.errors import ConfigurationError

CAMPAIGN = """
format = "bench-campaign"
format_version = "1.0"
name = "one"
title = "One point"

[[stages]]
name = "one"

[[stages.points]]
sequence = "constant_velocity"
velocities = ["10 deg/s"]
"""


@pytest.mark.parametrize(
    ("lines", "end"),
    [
        ('load_torques = ["500 N"]', "use one of N*m, Nm, mN*m, kN*m, kNm"),
        ("repeats = 0", "Input should be greater than or equal to 1"),
        ('temperatures = ["x"]', 'such as "50 degC"'),
        ('load_torques = ["500 N", "3 kg"]', "(and 1 more)"),
        ("repeats = 0\nfoo = 1", "(and 1 more)"),
        ("load_torques = []", "Tuple should have at least 1 item after validation, not 0"),
    ],
)
def test_only_faults_of_the_writer_are_counted(lines: str, end: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_campaign(f"{CAMPAIGN}{lines}\n", "mine.toml")
    assert str(caught.value).endswith(end)


def test_a_misspelt_key_is_one_fault() -> None:
    text = load_bench("rh380n").text
    assert text.count("\nratio = ") == 1
    with pytest.raises(ConfigurationError) as caught:
        parse_bench(text.replace("\nratio = ", "\nratoi = "), "mine.toml")
    assert str(caught.value).endswith('there is no such key, "ratio" is missing and may be meant')
