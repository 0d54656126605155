"""Trends over HTTP: gearboxes, and one of them over its campaigns."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from bench.trend import kept
from tests.bench.recording.builders import write
from tests.bench.service.conftest import Client
from tests.bench.trend.conftest import identified


def test_a_gearbox_is_followed_over_what_is_identified(client: Client, tmp_path: Path) -> None:
    for month in (3, 6, 9):
        folder = tmp_path / "recordings" / f"month-{month}"
        folder.mkdir(parents=True)
        begun = datetime(2026, month, 5, 8, tzinfo=UTC)
        write(folder / "r001.h5", rows=60, gearbox_serial="RH-7", started_at=begun, campaign_id=folder.name)
        if month != 9:
            kept.store(identified(folder.name), folder, kept.stamp_of(folder))
    assert client.get("gearboxes") == [{"serial": "RH-7", "campaigns": 3}]
    found = client.get("trend", params={"gearbox": "RH-7"})
    assert [one["state"] for one in found["campaigns"]] == ["identified", "identified", "not yet"]
    assert "1 of 3 campaigns are not identified yet" in found["lines"][0]
    assert {one["key"] for one in found["series"]} >= {"hysteresis", "friction.5", "order.1.positive"}
    later = client.get("trend", params={"gearbox": "RH-7", "since": "2026-05-01"})
    assert [one["folder"] for one in later["campaigns"]] == ["month-6", "month-9"]
    refused = client.http.get("/api/trend", params={"gearbox": "none"})
    assert refused.status_code == 422
    assert "there are: RH-7" in refused.json()["problem"]
    # what is kept is no folder of recordings
    assert {one["name"] for one in client.get("folders")} == {"month-3", "month-6", "month-9"}
