"""Planning on the page: a schema made of the definitions, TOML of a form, drafts planned, campaigns saved."""

from __future__ import annotations

import json
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.campaigns import load_campaign, parse_campaign, shipped_campaigns
from bench.campaigns.planning.registry import sequence_names
from bench.errors import BenchError, ConfigurationError
from bench.service.campaigns.schema import campaign_schema
from bench.service.campaigns.toml import toml
from tests.bench.service.conftest import Client

LIBRARY = resources.files("bench.campaigns") / "library"
KEYS = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=8)
LEAVES = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(st.characters(codec="utf-8", exclude_categories=["Cs"])),
)
VALUES = st.recursive(
    LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3), max_leaves=8
)


def table(**changes: Any) -> dict[str, Any]:
    block = {
        "sequence": "constant_velocity",
        "load_torques": ["0 N*m", "350 N*m"],
        "velocities": ["10 deg/s"],
        **changes,
    }
    stage = {"name": "first", "order": "listed", "points": [block]}
    return {"format": "bench-campaign", "format_version": "1.0", "name": "mine", "title": "Mine", "stages": [stage]}


@pytest.mark.parametrize("name", shipped_campaigns())
def test_every_shipped_campaign_is_as_the_schema_says(name: str) -> None:
    content = tomllib.loads((LIBRARY / f"{name}.toml").read_text("utf-8"))
    jsonschema.validate(content, campaign_schema())
    again = toml(content)
    assert tomllib.loads(again) == content
    assert parse_campaign(again, name).stages == load_campaign(name).stages


@pytest.mark.parametrize(
    "wrong",
    [
        {"load_torques": [350]},
        {"load_torques": ["350 deg"]},
        {"load_torques": []},
        {"velocities": ["fast"]},
        {"temperatures": ["30 K"]},
        {"sequence": "no_such"},
        {"options": {"revolution": 1.0}},
        {"options": {"revolutions": "1 rad"}},
        {"repeats": 0},
        {"repeats": 1.5},
    ],
)
def test_what_the_schema_refuses_the_reader_refuses_as_well(wrong: dict[str, Any]) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(table(**wrong), campaign_schema())
    with pytest.raises(BenchError):
        parse_campaign(toml(table(**wrong)), "the draft").points(22.0)


def test_the_schema_has_the_options_of_every_sequence_with_their_kinds() -> None:
    definitions = campaign_schema()["$defs"]
    assert set(sequence_names()) <= set(definitions)
    amplitude = definitions["reversal"]["properties"]["amplitude"]
    assert amplitude["kind"] == "angle"
    assert "deg" in amplitude["units"]
    assert definitions["reversal"]["properties"]["cycles"] == {"type": "integer", "default": 3}
    assert definitions["BlockSection"]["properties"]["velocities"]["items"]["kind"] == "speed"
    assert json.dumps(campaign_schema(), allow_nan=False)


@given(st.dictionaries(KEYS, VALUES | st.lists(st.dictionaries(KEYS, LEAVES, max_size=3), min_size=1, max_size=3)))
def test_what_is_written_as_toml_is_read_again(content: dict[str, Any]) -> None:
    assert tomllib.loads(toml(content)) == content


@pytest.mark.parametrize("value", [None, float("nan"), float("inf"), "\ud800", [None]])
def test_what_toml_cannot_hold_is_named(value: Any) -> None:
    with pytest.raises(ConfigurationError, match="load_torques"):
        toml({"load_torques": value})


def test_a_draft_is_planned_and_refused_in_one_sentence(client: Client) -> None:
    def plan(status: int = 200, **body: Any) -> Any:
        answer = client.http.post("/api/plan", json=body)
        assert answer.status_code == status, answer.text
        return answer.json()

    found = plan(table=table())
    assert found["points"] == 2
    assert found["energy_j"] > 0.0
    assert tomllib.loads(found["text"]) == table()
    assert plan(text=found["text"])["tasks"] == found["tasks"]
    assert "limits.load_torque" in plan(422, table=table(load_torques=["90 kN*m"]))["problem"]
    assert "needs its unit" in plan(422, table=table(load_torques=[350]))["problem"]
    assert "either text" in plan(409)["problem"]


def test_a_campaign_is_saved_offered_edited_and_its_earlier_version_kept(client: Client, tmp_path: Path) -> None:
    saved = client.ask("campaigns", name="Ann", campaign="mine.toml", table=table())
    assert saved["campaign"] == "mine.toml"
    offered = {one["name"]: one for one in client.get("campaigns")}
    assert offered["mine.toml"]["laboratory"]
    assert not offered["quick"]["laboratory"]
    assert client.get("campaigns/mine.toml/definition")["table"] == table()
    assert client.get("campaigns/quick/definition")["table"]["name"] == "quick"
    longer = table(repeats=2)
    refused = client.ask("campaigns", 409, name="Ann", campaign="mine.toml", table=longer)
    assert "already" in refused["problem"]
    client.ask("campaigns", name="Ann", campaign="mine.toml", table=longer, replaces=True)
    assert client.get("campaigns/mine.toml/definition")["table"] == longer
    (earlier,) = (tmp_path / "recordings" / ".service" / "campaigns" / "earlier").iterdir()
    assert tomllib.loads(earlier.read_text("utf-8")) == table()
    client.take()
    run = client.ask("runs", name="Ann", secret=client.secret, campaign="mine.toml")
    assert run["state"] == "queued"
    assert any("saved the campaign mine.toml" in entry["text"] for entry in client.get("book"))


def test_what_is_no_campaign_is_not_saved_and_a_program_not_shown(client: Client, tmp_path: Path) -> None:
    client.ask("campaigns", 422, name="Ann", campaign="mine.toml", table={"name": "mine"})
    client.ask("campaigns", 422, name="Ann", campaign="a.b/../c", table=table())
    folder = tmp_path / "recordings" / ".service" / "campaigns"
    assert not folder.exists()
    folder.mkdir()
    (folder / "program.py").write_text("campaign = None\n")
    assert client.http.get("/api/campaigns/program.py/definition").status_code == 404
