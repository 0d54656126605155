"""Fixtures of more than one folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.veth import VethPair, veth_pair


@pytest.fixture(scope="session")
def veth() -> Iterator[VethPair]:
    """A veth pair that lives as long as the test session; skips where none can be made."""
    with veth_pair() as pair:
        yield pair
