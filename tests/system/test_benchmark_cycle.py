"""``bench benchmark cycle`` in its short form: what it counts, never how punctual a busy machine is."""

from __future__ import annotations

import json
from pathlib import Path

from typer.testing import CliRunner

from bench.cli.app import make_app
from tests.veth import VethPair, real_time_allowed


def test_cycles_are_measured_and_a_missing_c_loop_is_said(veth: VethPair, tmp_path: Path) -> None:
    priority = "80" if real_time_allowed() else "0"
    arguments = ["benchmark", "cycle", "--seconds", "1", "--rate", "1000", "--interface", veth.near, "--far", veth.far]
    arguments += ["--priority", priority, "--soem", str(tmp_path), "--json"]
    done = CliRunner().invoke(make_app(), arguments)
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert any("no C loop" in note for note in found["notes"])
    (at,) = found["rates"]
    assert (at["rate"], at["c"], at["ratio"]) == (1000.0, None, None)
    loop = at["python"]
    assert loop["cycles"] > 0
    assert loop["cycles"] + loop["missed"] >= 500
    for part in ("wake", "trip", "cycle"):
        times = loop[part]
        assert 0.0 <= times["median"] <= times["p99"] <= times["p999"] <= times["maximum"]
    assert sum(loop["cycle"]["histogram"]) == loop["cycles"]
    assert loop["cycle"]["median"] >= loop["trip"]["median"]
    assert loop["wrong"] == 0
