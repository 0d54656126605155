"""What the first look makes of names: a ``/`` before the unit, axes of a mount, nested names, numbers of cycles."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bench.importing.looking import Draft, draft, take_inventory
from tests.bench.importing import builders

_T = np.arange(1000) / 100
_WAVE = np.sin(2 * _T)


def _draft(folder: Path, **columns: Any) -> Draft:
    return draft(take_inventory(builders.csv(folder / "a.csv", **columns)), folder / "a.toml")


def _tables(made: Draft, kind: str = "channels") -> dict[str, Any]:
    tables: dict[str, Any] = tomllib.loads(made.text()).get(kind, {})
    return tables


def test_a_unit_after_a_mark_alone_is_the_unit_of_its_column(tmp_path: Path) -> None:
    made = _draft(
        tmp_path,
        **{"time/s": _T, "cam_angle/deg": (400 * _T) % 360, "v/m/s": _WAVE, "torque/V": _WAVE, "oil_p/bar": 2 + _WAVE},
    )
    channels, aux = _tables(made), _tables(made, "aux")
    assert channels["time"] == {"variable": "time/s", "unit": "s"}
    assert channels["motor_angle"] == {"variable": "cam_angle/deg", "unit": "deg", "wraps_at": 360.0}
    assert channels["motor_velocity"] == {"variable": "v/m/s", "unit": "m/s"}
    assert aux == {
        "torque": {"variable": "torque/V", "unit": "V"},
        "oil_p": {"variable": "oil_p/bar", "unit": "bar"},
    }
    (torque,) = made.lacking()
    assert torque.endswith("[aux.torque] to [channels.motor_torque], and a factor given, such as '120 N*m/V'")


def test_in_a_file_with_groups_the_mark_is_between_names(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["log/t"], file["log/position"], file["log/A"] = _T, 9 * _WAVE, _WAVE
    made = draft(take_inventory(tmp_path / "a.h5"), tmp_path / "a.toml")
    assert _tables(made)["motor_angle"]["variable"] == "log/position"
    assert _tables(made, "aux") == {"A": {"variable": "log/A"}}


def test_the_axes_of_a_mount_and_nested_names_are_known(tmp_path: Path) -> None:
    records = [{"t": t, "az": 200 + 90 * w, "mot": {"i": w}, "wind": 3.0 + w} for t, w in zip(_T, _WAVE, strict=True)]
    (tmp_path / "a.jsonl").write_text("\n".join(map(json.dumps, records)), encoding="utf-8")
    made = draft(take_inventory(tmp_path / "a.jsonl"), tmp_path / "a.toml")
    channels = _tables(made)
    assert (channels["motor_angle"]["variable"], channels["motor_torque"]["variable"]) == ("az", "mot.i")
    assert channels["motor_torque"]["torque_constant"] == "?"
    assert list(_tables(made, "aux")) == ["wind"]
    for name in ("azimuth", "El", "Elevation [deg]", "ant_az_deg"):
        assert _tables(_draft(tmp_path, t=_T, **{name: 90 * _WAVE}))["motor_angle"]["variable"] == name
    # the third of three accelerations, and electrical quantities
    for names in (("ax", "ay", "az"), ("P_el", "el_power")):
        assert set(_tables(_draft(tmp_path, t=_T, **dict.fromkeys(names, _WAVE)))) == {"time"}


def test_a_position_in_per_cent_is_advised_and_a_number_of_cycles_is_not(tmp_path: Path) -> None:
    cycle = np.arange(1000) // 50
    for name in ("Zyklus", "cycle_count", "Cycle No.", "Zykluszähler"):
        columns = {"t": _T, name: cycle, "Stellung [%]": 50 + 50 * _WAVE, "Motorstrom [A]": _WAVE}
        made = _draft(tmp_path, **columns)
        (angle,) = made.lacking()
        assert angle.endswith(
            "as [aux.Stellung] to [channels.motor_angle] ([channels.load_angle] if it is the output's), and a factor "
            "given, what 100 % is, such as '90 deg'"
        )
        del columns["Stellung [%]"]
        (angle,) = _draft(tmp_path, **columns).lacking()
        assert "as [aux.NAME] to [channels.motor_angle]" in angle
    # a column of which nothing is known comes after it, one that is called an angle before
    columns = {"t": _T, "foo": _WAVE, "Stellung [%]": _WAVE, "Motorstrom [A]": _WAVE}
    assert "as [aux.Stellung]" in _draft(tmp_path, **columns).lacking()[0]
