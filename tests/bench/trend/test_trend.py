"""A gearbox over months: what changed is found, what did not is not, and nothing is asked of where nobody measured."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from bench.archive import Index
from bench.errors import ConfigurationError
from bench.trend import gearboxes, identify_missing, kept, trend_of
from bench.trend.book import since_last
from bench.trend.quantities import Reference, Value
from bench.trend.series import reference_of, series_of
from tests.bench.identification.synthetic import Bench
from tests.bench.trend.conftest import GEARBOX, STD, STIFFNESS, identified

AT = Reference(5.0, 30.0)


def test_gearboxes_are_found_by_their_serial_number(index: Index) -> None:
    assert gearboxes(index) == {GEARBOX: 3, "RH-9": 1}


def test_a_changed_friction_is_said_and_nothing_else(root: Path, index: Index) -> None:
    found = trend_of(root, GEARBOX, index)
    assert found.reference == AT
    assert [(one.folder, one.state) for one in found.campaigns] == [(f"month-{m}", "identified") for m in (3, 6, 9)]
    assert {c.quantity.key for c in found.changed if c.changed} == {"friction.5", "friction.10"}
    assert len(found.lines) == 3
    assert f"Since month-6: 2 of {len(found.changed)} quantities of month-9 changed" in found.lines[0]
    assert "friction at 5 °/s, 30 °C 600 → 660 mN·m" in found.lines[1]
    assert "take 3 earlier campaigns" in found.lines[2]


def test_orders_hysteresis_and_stiffness_are_read_at_the_reference_point() -> None:
    by_key = {one.quantity.key: one.points[0].value for one in series_of([(0.0, identified("a"))], AT)}
    assert by_key["stiffness.positive"].value == pytest.approx(STIFFNESS)
    assert by_key["stiffness.positive"].std == pytest.approx(1e-3 * STIFFNESS)
    assert by_key["hysteresis"] == Value(pytest.approx(8e-6), pytest.approx(STD * 2**0.5))
    assert by_key["order.46.negative"] == Value(pytest.approx(2e-5), pytest.approx(STD))
    assert by_key["heat.resistance"] == Value(0.05, 0.001)


def test_the_strongest_orders_come_first_and_one_that_moved_is_outside() -> None:
    dated = [(float(k), identified(f"c{k}", shift=1e-8 * k)) for k in range(4)] + [(4.0, identified("c4", shift=5e-6))]
    series = series_of(dated, AT)
    assert [one.quantity.key for one in series][:3] == ["order.1.positive", "order.46.positive", "order.3.positive"]
    outside = {one.quantity.key for one in series if one.points[-1].outside}
    assert outside == {"order.1.positive", "order.46.positive", "order.3.positive"}


def test_a_campaign_says_nothing_of_where_it_did_not_measure() -> None:
    one = identified("a")
    warm = replace(one, measured={name: ((0.0, 4.0, 60.0), (0.0, 12.0, 70.0)) for name in one.measured})
    assert reference_of([warm]) is None
    assert reference_of([one, warm]) == AT
    keys = {s.quantity.key for s in series_of([(0.0, one), (1.0, warm)], AT) if len(s.points) == 2}
    assert not {"order.1.positive", "stiffness.positive", "hysteresis"} & keys
    assert "noise.positive" in keys


def test_without_several_torques_there_is_no_stiffness() -> None:
    one = identified("a")
    assert one.model is not None
    model = one.model.transmission_error()
    assert model is not None
    positive = model.direction(1.0)
    assert positive is not None
    assert positive.offset_covariance is not None
    flat = positive.offset_covariance.copy()
    flat[3, 3] = 0.0
    changed = replace(model, positive=replace(positive, offset_covariance=flat))
    other = replace(one, model=one.model.with_transmission_error(changed))
    keys = {s.quantity.key for s in series_of([(0.0, other)], AT)}
    assert "stiffness.positive" not in keys
    assert "stiffness.negative" in keys


def test_limits_come_with_the_third_earlier_campaign_and_one_outside_moves_none() -> None:
    sizes = (0.6, 0.601, 0.599, 0.6005, 0.8, 0.8)
    moved = [(float(k), identified(f"c{k}", size)) for k, size in enumerate(sizes)]
    (series,) = [s for s in series_of(moved, AT) if s.quantity.key == "friction.5"]
    assert [point.limits is not None for point in series.points] == [False] * 3 + [True] * 3
    assert [point.outside for point in series.points] == [False] * 4 + [True, True]
    assert series.points[5].limits is not None
    assert series.points[5].limits.campaigns == 4


def test_what_is_kept_comes_back_as_it_was(root: Path) -> None:
    back, one = kept.load(root / "month-3"), identified("month-3")
    assert back is not None
    assert (back.measured, back.noise, back.friction) == (one.measured, one.noise, one.friction)
    assert back.parameter("R") == Value(0.05, 0.001)
    assert back.parameter("C") is None


def test_a_folder_that_grew_is_identified_anew_and_a_bad_one_says_why(root: Path, tmp_path: Path) -> None:
    folder = root / "month-3"
    shutil.copy(folder / "r001.h5", folder / "r999.h5")
    assert kept.load(folder) is None
    (root / "empty").mkdir()
    bad = kept.identify(root / "empty")
    assert bad.model is None
    assert bad.why
    assert kept.load(root / "empty") == bad


def test_what_is_kept_and_spoiled_is_made_anew(root: Path) -> None:
    place = root / ".identified" / "month-3" / "trend.json"
    whole = place.read_text("utf-8")
    another = json.dumps(json.loads(whole) | {"version": kept.VERSION + 1})
    for spoiled in (whole[:100], "[]", another):
        place.write_text(spoiled, "utf-8")
        assert kept.load(root / "month-3") is None
    place.unlink()
    assert kept.load(root / "month-3") is None


def test_what_was_before_a_repair_is_left_out(root: Path, index: Index) -> None:
    since = datetime(2026, 5, 1, tzinfo=UTC).timestamp()
    assert [one.folder for one in trend_of(root, GEARBOX, index, since).campaigns] == ["month-6", "month-9"]
    with pytest.raises(ConfigurationError, match=r'no campaign of gearbox "RH".*RH-7, RH-9'):
        trend_of(root, "RH", index)


def test_campaigns_that_wait_are_said(root: Path, index: Index) -> None:
    found = trend_of(root, "RH-9", index)
    assert found.campaigns[0].state == "not yet"
    assert found.lines == (
        "No campaign is identified; what changed takes two. 1 of 1 campaigns are not identified yet.",
    )
    assert identify_missing(root, GEARBOX, index) == 0


def test_a_report_says_what_changed_up_to_its_own_campaign(root: Path) -> None:
    assert "Since month-3: 0 of" in since_last(root / "month-6")[0]
    assert since_last(root / "month-3") == ()
    assert since_last(root / "month-10") == ()


def test_json_has_the_units_it_names(root: Path, index: Index) -> None:
    content = trend_of(root, GEARBOX, index).as_dict()
    (friction,) = [one for one in content["series"] if one["key"] == "friction.5"]
    assert friction["unit"] == "mN·m"
    assert [point["value"] for point in friction["points"]] == pytest.approx([600.0, 600.0, 660.0])
    json.dumps(content, allow_nan=False)


def test_a_value_without_a_standard_deviation_is_no_point() -> None:
    bare = replace(identified("a"), friction={(5.0, 30.0): Value(0.5, 0.0)})
    assert [s for s in series_of([(0.0, bare)], AT) if s.quantity.key == "friction.5"] == []


def test_a_campaign_is_identified_and_its_friction_is_that_of_the_bench(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    folder.mkdir()
    bench = Bench(folder, rate=250.0, serial=GEARBOX)
    for torque in (0.0, 1000.0):
        for speed in (30.0, 45.0, -30.0, -45.0):
            bench.write(torque, float(np.deg2rad(speed)), 30.0)
    found = kept.identify(folder)
    assert found.why == ""
    f_c, f_v, f_vt, _ = bench.friction
    omega = 185.0 * np.deg2rad(45.0)
    value = found.friction[45.0, 30.0]
    assert value.value == pytest.approx(f_c + omega * (f_v + 5.0 * f_vt), abs=5e-3)
    assert 0.0 < value.std < 0.01
    assert set(found.friction) == {(30.0, 30.0), (45.0, 30.0)}


def test_friction_is_said_of_the_speed_and_temperature_that_were_measured_without_load(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    folder.mkdir()
    bench = Bench(folder, rate=250.0, serial=GEARBOX)
    for torque, speed in ((0.0, 30.0), (0.0, -30.0), (1000.0, 30.0), (1000.0, -30.0), (1000.0, 20.0), (1000.0, -20.0)):
        bench.write(torque, float(np.deg2rad(speed)), 22.1)
    one = kept.identify(folder)
    assert set(one.friction) == {(30.0, 22.0)}
    at = reference_of([one])
    assert at == Reference(30.0, 22.0)
    names = [series.quantity.name for series in series_of([(0.0, one)], at)]
    assert [name for name in names if name.startswith("friction at")] == ["friction at 30 °/s, 22 °C"]


@pytest.mark.parametrize(
    ("at", "measured"),
    [
        (Reference(10.0, 22.0), True),
        (Reference(10.0, 20.0), False),
        (Reference(10.0, 23.0), False),
        (Reference(8.0, 22.0), False),
        (Reference(12.5, 22.0), False),
    ],
)
def test_a_reference_point_is_where_recordings_were_made(at: Reference, measured: bool) -> None:
    assert at.measured((0.0, 9.998, 22.0), (350.0, 10.002, 22.1)) is measured
