"""The examples in docs/campaigns.md are run, so that they stay true."""

import re
from pathlib import Path

import pytest

from bench.campaigns import Campaign, load_campaign, make_plan
from bench.campaigns.planning.registry import sequence_names
from bench.configuration import load_bench

DOCUMENT = Path(__file__).parents[3] / "docs" / "campaigns.md"
EXAMPLES = re.findall(r"```(toml|python)\n(.*?)```", DOCUMENT.read_text("utf-8"), re.DOTALL)


@pytest.mark.parametrize(("kind", "text"), EXAMPLES, ids=[kind for kind, _ in EXAMPLES])
def test_examples_are_campaigns(kind: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / f"mine.{'toml' if kind == 'toml' else 'py'}"
    path.write_text(text, "utf-8")
    campaign = load_campaign(path)
    assert isinstance(campaign, Campaign)
    assert make_plan(campaign, load_bench("rh380n").configuration).points >= 8


def test_every_sequence_is_described() -> None:
    described = set(re.findall(r"`(\w+)`", DOCUMENT.read_text("utf-8")))
    assert set(sequence_names()) <= described
