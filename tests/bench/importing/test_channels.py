"""What a mapping makes of columns: units, constants, sums, products, auxiliary quantities, axes of metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.importing import Imported, import_recordings
from bench.importing.looking import take_inventory
from bench.recording import Rejected
from bench.recording.validation import validate
from tests.bench.importing import builders

_T = np.round(np.arange(200) * 0.01, 6)
_COUNTS = (np.arange(200) * 37) % 4096
_I = np.sin(_T)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    builders.csv(tmp_path / "a.csv", t=_T, n=_COUNTS, i=_I, left=_T + 1, right=2 * _T, p=3.0 + _T, v=np.full(200, 60.0))
    return tmp_path


def test_constants_make_angles_of_counts_and_torques_of_currents(folder: Path) -> None:
    channels = """
motor_angle = {variable = "n", counts_per_revolution = 4096, wraps_at = 4096}
motor_torque = {variable = "i", unit = "mA", torque_constant = 0.12}
load_torque = {variable = "i", unit = "V", factor = "-50 N*m/V", offset = 0.5}
"""
    recording = builders.one(folder, channels, ratio="50.0").recording
    np.testing.assert_allclose(recording.si("motor_angle"), np.arange(200) * 37 * 2 * np.pi / 4096, rtol=1e-12)
    np.testing.assert_allclose(recording.si("motor_torque"), 0.12e-3 * _I, rtol=1e-12)
    np.testing.assert_allclose(recording.si("load_torque"), -50.0 * (_I + 0.5), rtol=1e-12)
    assert recording.raw("motor_angle").dtype.kind == "i"
    assert (recording.axis, recording.linear) == ("rotary", False)
    assert validate(recording.path).violations == ()


def test_columns_are_added_and_multiplied(folder: Path) -> None:
    channels = """
motor_velocity = {variable = "v", unit = "rpm"}
load_torque = {sum = [
    {variable = "left", unit = "kN", factor = "0.4 m"}, {variable = "right", unit = "N", factor = "-400 mm"}]}
motor_torque = {variable = "i", times = ["p"], unit = "N*m"}
"""
    recording = builders.one(folder, channels, ratio="50.0").recording
    np.testing.assert_allclose(recording.si("load_torque"), 400.0 * (_T + 1) - 0.4 * 2 * _T, rtol=1e-12)
    np.testing.assert_allclose(recording.si("motor_torque"), _I * (3.0 + _T), rtol=1e-12)
    np.testing.assert_allclose(recording.si("motor_velocity"), 2 * np.pi)


def test_an_angle_that_was_not_measured_is_the_integral_of_the_speed_and_says_so(folder: Path) -> None:
    done = builders.one(folder, 'motor_velocity = {variable = "v", unit = "rpm"}', ratio="50.0")
    np.testing.assert_allclose(done.recording.si("motor_angle"), 2 * np.pi * _T, atol=1e-12)
    assert any(note.startswith("motor_angle is the integral of motor_velocity") for note in done.notes)
    assert any("is the integral" in event.text for event in done.recording.events)
    (folder / "out/a.h5").unlink()
    channels = 'motor_velocity = {variable = "v", unit = "rpm"}\nload_angle = {variable = "p", unit = "rad"}'
    assert "motor_angle" not in builders.one(folder, channels, ratio="50.0").recording.channels


def test_where_a_motors_torque_is_there_and_no_angle_of_it_the_outputs_angle_serves(folder: Path) -> None:
    channels = """
motor_velocity = {variable = "v", unit = "rpm"}
motor_torque = {variable = "i", unit = "Ncm"}
load_angle = {variable = "p", unit = "deg"}
"""
    done = builders.one(folder, channels, ratio="50.0")
    np.testing.assert_allclose(done.recording.si("motor_angle"), np.radians(50.0 * (3.0 + _T)), rtol=1e-12)
    np.testing.assert_allclose(done.recording.si("motor_torque"), 0.01 * _I, rtol=1e-12)
    assert "load_angle" not in done.recording.channels
    assert any("motor_angle is load_angle times gearbox.ratio 50" in note for note in done.notes)
    assert "times gearbox.ratio 50" in done.recording.specs["motor_angle"].origin
    assert validate(done.recording.path).violations == ()


def test_what_is_no_channel_is_kept_as_aux_with_its_unit(folder: Path) -> None:
    done = builders.one(
        folder, 'motor_torque = {variable = "i", unit = "N*m"}', aux='oil_pressure = {variable = "p", unit = "bar"}'
    )
    assert done.recording.specs["aux/oil_pressure"].unit == "Pa"
    np.testing.assert_allclose(done.recording.si("aux/oil_pressure"), 1e5 * (3.0 + _T))


def test_a_linear_axis_speaks_of_metres_and_newtons(folder: Path) -> None:
    channels = """
motor_angle = {variable = "n", unit = "counts", factor = "0.25 um/count", wraps_at = 4096}
motor_torque = {variable = "i", unit = "A", torque_constant = 80.0}
"""
    recording = builders.one(folder, channels.replace("80.0", '"80 N/A"')).recording
    assert (recording.axis, recording.linear) == ("linear", True)
    assert [recording.specs[name].unit for name in ("motor_angle", "motor_torque")] == ["m", "N"]
    (folder / "out/a.h5").unlink()
    screw = 'motor_angle = {variable = "p", unit = "rad", factor = "10 mm/rev"}\n' + channels.splitlines()[2]
    recording = builders.one(folder, screw, changes={"gearbox.axis": "linear"}).recording
    np.testing.assert_allclose(recording.si("motor_angle"), (3.0 + _T) * 0.01 / (2 * np.pi))
    np.testing.assert_allclose(recording.si("motor_torque"), 80.0 * _I)
    assert validate(recording.path).violations == ()


def test_a_file_a_channel_is_found_by_the_recordings_star(tmp_path: Path) -> None:
    for run in ("3", "7"):
        builders.csv(tmp_path / f"run{run}_angle.csv", t=_T, q=_T * int(run))
        builders.csv(tmp_path / f"run{run}_torque.csv", M=_I)
    channels = """
motor_angle = {variable = "q", unit = "rad"}
motor_torque = {variable = "M", unit = "N*m", file = "run*_torque.csv"}
"""
    done = builders.run(tmp_path, channels, file="run*_angle.csv", ratio="5.0")
    found = [item.recording for item in done if isinstance(item, Imported)]
    assert [recording.recording_id for recording in found] == ["run3_angle", "run7_angle"]
    np.testing.assert_allclose(found[1].si("motor_angle"), 7 * _T)
    np.testing.assert_allclose(found[1].si("motor_torque"), _I)


def test_recordings_of_the_same_name_in_several_folders_get_that_of_the_folder(tmp_path: Path) -> None:
    for run in ("a", "b"):
        (tmp_path / run).mkdir()
        builders.csv(tmp_path / run / "log.csv", t=_T, M=_I)
    done = builders.run(tmp_path, 'motor_torque = {variable = "M", unit = "N*m"}', file="*/log.csv")
    assert [item.recording.recording_id for item in done if isinstance(item, Imported)] == ["a-log", "b-log"]


def test_samples_that_are_not_there_are_held_where_the_mapping_says_so(tmp_path: Path) -> None:
    slow: list[object] = [20.0 + i if i % 10 == 0 else "" for i in range(200)]
    builders.csv(tmp_path / "a.csv", t=_T, M=_I, T=np.array(slow, dtype=object))
    channels = 'motor_torque = {variable = "M", unit = "N*m"}\ntemperature = {variable = "T", unit = "degC"%s}'
    assert "missing = 'hold' or 'interpolate'" in builders.why(tmp_path, channels % "")
    recording = builders.one(tmp_path, channels % ', missing = "hold"').recording
    assert recording.si("temperature", 8, 12).tolist() == [20.0, 20.0, 30.0, 30.0]


@pytest.mark.parametrize(
    ("channels", "sentence"),
    [
        (
            'motor_torque = {variable = "i", unit = "A"}',
            "channels.motor_torque: unit 'A' is a current's, torque_constant",
        ),
        (
            'motor_torque = {variable = "i"}',
            "channels.motor_torque.unit: is missing, it should be one that becomes 'N·m'",
        ),
        (
            'motor_torque = {variable = "i", unit = "A", torque_constant = "high"}',
            "channels.motor_torque.torque_constant: 'high' should be a number with a unit, such as '0.12 N*m/A'",
        ),
        (
            'motor_angle = {variable = "n", unit = "deg", counts_per_revolution = 4096}',
            "channels.motor_angle.unit: is 'deg', with 'counts_per_revolution' it should be 'counts', or left out",
        ),
        (
            'motor_torque = {sum = [{variable = "i", unit = "N*m"}, {column = 9, unit = "N*m"}]}',
            "a.csv: has 7 columns, column 9 was asked for",
        ),
        (
            'load_torque = {sum = [{variable = "i", unit = "N*m"}, {variable = "p", unit = "N"}]}',
            "unit 'N' should be one that becomes 'N·m'",
        ),
        (
            'motor_torque = {variable = "i", unit = "N*m", times = ["q"]}',
            "there is no variable 'q'; the file has t, n, i",
        ),
        ('motor_torque = {variable = "?", unit = "N*m"}', "channels.motor_torque.variable is still '?'"),
        (
            'motor_torque = {variable = "i", unit = "N*m", torque_constant = 1.0, factor = 2.0}',
            "channels.motor_torque: has both 'torque_constant' and 'factor', one conversion is enough: 'factor'",
        ),
        (
            'motor_torque = {variable = "i", torque_constant = 1.0, counts_per_revolution = 4096}',
            "the one that is not of this channel should be left out.",
        ),
        (
            'motor_torque = {variable = "i", unit = "N*m", offset = "3 kg"}',
            "channels.motor_torque.offset: unit 'kg' should be one that becomes 'N·m'",
        ),
        (
            'motor_angle = {variable = "n", unit = "counts", counts_per_revolution = 4096, offset = "50 %"}',
            "channels.motor_angle.offset: unit '%' should be one that becomes 'rad'",
        ),
        ('motor_torque = {variable = "i", unit = "N*m", scale = 0.0}', "scale: is 0"),
        ('"a/b" = {variable = "i"}', "channels.a/b should have a name without '/'; [aux.NAME] is the table of others"),
    ],
)
def test_a_wrong_channel_is_one_sentence_with_key_and_what_would_be_right(
    folder: Path, channels: str, sentence: str
) -> None:
    try:
        (done,) = builders.run(folder, channels, ratio="50.0")
        assert isinstance(done, Rejected)
        message = done.why
    except ConfigurationError as error:
        message = str(error)
    assert sentence in message
    assert "\n" not in message


def test_axes_and_units_have_to_agree(folder: Path) -> None:
    channels = 'motor_angle = {variable = "p", unit = "rad"}\nmotor_torque = {variable = "i", unit = "N"}'
    with pytest.raises(ConfigurationError, match=r"channels.motor_angle becomes rad and channels.motor_torque N; on a"):
        builders.run(folder, channels)
    with pytest.raises(ConfigurationError, match="ratio should be 1 on a linear axis"):
        builders.run(folder, channels, ratio="5.0", changes={"gearbox.axis": "linear"})


def test_scripts_see_a_linear_axis_in_metres(folder: Path) -> None:
    from bench.api import to_xarray

    channels = 'motor_angle = {variable = "p", unit = "mm"}\nload_angle = {variable = "left", unit = "mm"}'
    data = to_xarray(builders.one(folder, channels, aux='oil = {variable = "i", unit = "bar"}').recording)
    assert data.attrs["axis"] == "linear"
    assert data["transmission_error"].attrs["units"] == data["motor_angle"].attrs["units"] == "m"
    assert data["aux/oil"].attrs["units"] == "Pa"


def test_a_misspelt_channel_is_kept_and_said(folder: Path) -> None:
    channels = 'motor_velocity = {variable = "v", unit = "rpm"}\nmotor_troque = {variable = "i", unit = "N*m"}'
    done = builders.one(folder, channels)
    assert "motor_troque" in done.recording.channels
    (warning,) = done.warnings
    assert "channels.motor_troque is no channel of the bench" in warning
    assert "did you mean [channels.motor_torque]?" in warning
    (folder / "out/a.h5").unlink()
    # beside the right one it is another quantity of that name
    both = channels + '\nmotor_torque = {variable = "i", unit = "N*m"}'
    assert builders.one(folder, both).warnings == ()


def test_a_column_that_is_not_there_is_said_with_its_key(folder: Path) -> None:
    message = builders.why(folder, 'motor_torque = {variable = "I", unit = "N*m"}')
    assert f"{folder / 'map.toml'}: channels.motor_torque: {folder / 'a.csv'}: there is no variable 'I'" in message


def test_a_key_of_a_table_that_is_not_there_names_the_one_that_is_meant(folder: Path) -> None:
    channels = 'motor_torque = {variable = "i", unit = "N*m"}'
    with pytest.raises(ConfigurationError, match=r"motor_torqe: needs .*Did you mean 'channels\.motor_torque'"):
        builders.one(folder, channels, changes={"channels.motor_torqe.unit": "mNm"})


@pytest.mark.parametrize(
    ("factor", "right"),
    [('"10 mm/rev"', "0.001 mm/count"), ('"1 cm / turn"', "0.0001 cm/count"), ("0.5", "0.001 mm/count")],
)
def test_counts_per_revolution_and_a_factor_are_refused_with_what_would_be_right(
    folder: Path, factor: str, right: str
) -> None:
    channels = """
motor_angle = {{variable = "n", unit = "counts", {}}}
motor_torque = {{variable = "i", unit = "A", torque_constant = "80 N/A"}}
"""
    with pytest.raises(ConfigurationError) as error:
        builders.run(folder, channels.format(f"counts_per_revolution = 10000, factor = {factor}"))
    said = str(error.value)
    assert f"{folder / 'map.toml'}: channels.motor_angle: has both 'counts_per_revolution' and 'factor'" in said
    assert f"unit = 'counts' and factor = '{right}' without 'counts_per_revolution' would be right" in said
    assert "Did you mean" not in said
    recording = builders.one(folder, channels.format(f'factor = "{right}"')).recording
    np.testing.assert_allclose(recording.si("motor_angle"), _COUNTS * 0.01 / 10000, rtol=1e-12)


@pytest.mark.parametrize(
    ("unit", "offset", "added"),
    [
        ("counts_per_revolution = 4096", "-2048", -np.pi),
        ("counts_per_revolution = 4096", '"-180 deg"', -np.pi),
        ("counts_per_revolution = 4096", '"-2048 counts"', -np.pi),
        ("counts_per_revolution = 4096", '"-0.5 rev"', -np.pi),
        ('unit = "deg"', '"90"', np.pi / 2),
        ('unit = "deg"', '".5 rad"', 0.5),
        ('unit = "V", factor = "36 deg/V"', '"500 mV"', np.radians(18.0)),
        ('unit = "V", factor = "36 deg/V"', '"18 deg"', np.radians(18.0)),
        ('unit = "deg"', '"k"', np.radians(60.0)),
    ],
)
def test_an_offset_is_in_the_unit_of_the_file_or_says_its_own(
    tmp_path: Path, unit: str, offset: str, added: float
) -> None:
    np.savez(tmp_path / "a.npz", t=_T, n=_COUNTS.astype(float), i=_I, k=np.array([60.0]))
    angles = []
    for more in ("", f", offset = {offset}"):
        channels = f'motor_angle = {{variable = "n", {unit}{more}}}\nmotor_torque = {{variable = "i", unit = "N*m"}}'
        recording = builders.one(tmp_path, channels, file="a.npz", ratio="50.0").recording
        angles.append(recording.si("motor_angle"))
        recording.path.unlink()
    np.testing.assert_allclose(angles[1] - angles[0], added, rtol=1e-9)


def test_an_offset_of_a_temperature_is_a_difference(folder: Path) -> None:
    channels = (
        'motor_torque = {variable = "i", unit = "N*m"}\ntemperature = {variable = "p", unit = "degF", offset = "2 K"}'
    )
    recording = builders.one(folder, channels).recording
    np.testing.assert_allclose(recording.si("temperature"), (3.0 + _T - 32.0) / 1.8 + 2.0)


def test_a_file_of_measurements_is_no_mapping_and_the_way_to_one_is_said(folder: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"a\.csv: is not a readable TOML file .*bench import --look a\.csv"):
        list(import_recordings(folder / "a.csv", folder / "out"))


@pytest.mark.parametrize(
    ("key", "value", "most"),
    [("signed_bits", 16, 65535), ("sign_bit", 10, 2047)],  # -1 as 65535; -1 as 1025
)
def test_integers_without_their_sign_get_it_back(tmp_path: Path, key: str, value: int, most: int) -> None:
    whole = np.round(400 * np.sin(5 * _T)).astype(np.int64)
    written = whole % 65536 if key == "signed_bits" else np.where(whole < 0, 1024 - whole, whole)
    builders.csv(tmp_path / "a.csv", t=_T, q=_T, n=written)
    channels = f"""
motor_angle = {{variable = "q", unit = "rad"}}
motor_torque = {{variable = "n", unit = "N*m", scale = 0.01, {key} = {value}}}
"""
    recording = builders.one(tmp_path, channels).recording
    np.testing.assert_allclose(recording.si("motor_torque"), 0.01 * whole, rtol=1e-12)
    builders.csv(tmp_path / "a.csv", t=_T, q=_T, n=whole)
    sentence = builders.why(tmp_path, channels)
    assert f"channels.motor_torque.{key}: the values are -" in sentence
    assert f"should be 0 to {most}" in sentence


def test_fill_values_count_as_missing_and_are_said_to(tmp_path: Path) -> None:
    load = _T + 1.0
    spoilt = load.copy()
    spoilt[[7, 8]] = (9.9e37, -1.2e36)
    builders.csv(tmp_path / "a.csv", t=_T, q=_T, L=spoilt)
    channels = 'motor_angle = {{variable = "q", unit = "rad"}}\nload_torque = {{variable = "L", unit = "N*m"{}}}'
    why = builders.why(tmp_path, channels.format(""))
    assert "load_torque is a fill value (1e+30 or more) in line 9, every sample should be a number" in why
    done = builders.one(tmp_path, channels.format(', missing = "interpolate"'))
    np.testing.assert_allclose(done.recording.si("load_torque"), load, rtol=1e-12)
    said = "load_torque: 2 of 200 samples are fill values (1e+30 or more in size, such as 9.9e37) and count as missing"
    assert f"{said}, the first in line 9" in done.notes
    builders.csv(tmp_path / "b.csv", t=_T, q=_T, L=np.full(_T.size, 9.91e37))
    lost = builders.why(tmp_path, channels.format(', missing = "hold"'), file="b.csv")
    assert lost.endswith("load_torque holds no number in any sample; leave the channel out of the mapping.")
    found = take_inventory(tmp_path / "a.csv")
    assert found.columns[2].span == (1.0, load[-1])
    assert any("L: 2 of 200 samples are no number" in sentence for sentence in found.missing_samples())


def test_a_value_that_stands_in_no_file_is_a_channel_of_its_recording(tmp_path: Path) -> None:
    for name in ("a", "b"):
        builders.csv(tmp_path / f"{name}.csv", t=_T, i=_I, q=_T)
    channels = (
        'motor_angle = {variable = "q", unit = "rad"}\n'
        'motor_torque = {sum = [{variable = "i", unit = "N*m"}, {value = 20, unit = "N", factor = "5 mm"}]}'
    )
    entry = 'channels.load_torque = {value = 120, unit = "N*cm"}\n[[recordings]]\nfile = "b.csv"\n'
    entry += 'channels.load_torque = {value = 0, unit = "N*m"}'
    a, b = builders.run(tmp_path, channels, entry=entry)
    assert isinstance(a, Imported)
    assert isinstance(b, Imported)
    np.testing.assert_allclose(a.recording.si("load_torque"), np.full(_T.size, 1.2), rtol=1e-12)
    np.testing.assert_allclose(b.recording.si("load_torque"), np.zeros(_T.size))
    np.testing.assert_allclose(a.recording.si("motor_torque"), _I + 0.1, rtol=1e-12)
    assert a.recording.specs["load_torque"].origin == "120 N*cm"
    assert validate(a.recording.path).violations == ()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('load_torque = {value = 1, variable = "i", unit = "N*m"}', "has a 'value' and a place in a file"),
        ('load_torque = {value = 1, wraps_at = 3, unit = "N*m"}', "has a 'value' and 'wraps_at', which is for"),
        ('load_torque = {value = 1, time = "t", unit = "N*m"}', "has a 'value' and a 'time' of its own"),
        ('load_torque = {value = nan, unit = "N*m"}', "has a 'value' that is no finite number"),
        ('load_torque = {unit = "N*m"}', "or 'sum', a 'value' that holds throughout"),
    ],
)
def test_a_value_goes_with_no_place(folder: Path, line: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        builders.run(folder, f'motor_velocity = {{variable = "v", unit = "rpm"}}\n{line}')


def test_values_alone_are_no_recording_and_no_time(folder: Path) -> None:
    with pytest.raises(ConfigurationError, match="every channel has a 'value'"):
        builders.run(folder, 'load_torque = {value = 1, unit = "N*m"}')
    with pytest.raises(ConfigurationError, match="a time that is the same throughout is none"):
        builders.run(folder, 'time = {value = 1, unit = "s"}\nmotor_velocity = {variable = "v", unit = "rpm"}')


def test_the_speed_of_the_output_alone_is_turned_into_the_motors(folder: Path) -> None:
    channels = 'load_velocity = {variable = "v", unit = "rpm"}\nmotor_torque = {variable = "i", unit = "N*m"}'
    done = builders.one(folder, channels, ratio="9.0")
    np.testing.assert_allclose(done.recording.si("motor_velocity"), 18 * np.pi, rtol=1e-12)
    np.testing.assert_allclose(done.recording.si("motor_angle"), 18 * np.pi * _T, atol=1e-11)
    assert "load_velocity" not in done.recording.specs
    said = "the motor's speed was not measured: motor_velocity is load_velocity times gearbox.ratio 9, so there is no"
    assert any(note.startswith(said) for note in done.notes)
    assert [event.level for event in done.recording.events if event.text.startswith(said)] == ["info"]
    (folder / "out/a.h5").unlink()
    without_torque = builders.one(folder, channels.splitlines()[0] + '\nload_torque = {variable = "i", unit = "N*m"}')
    assert {"load_velocity"} == {name for name in without_torque.recording.specs if "velocity" in name}
