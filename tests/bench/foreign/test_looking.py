"""What ``bench import --look`` makes of an FMU: what is in it, and a mapping that the comparison takes."""

from __future__ import annotations

import shutil
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.exchange.to_fmu import write_fmu
from bench.exchange.written import formulas_of
from bench.foreign.fmu import open_fmu
from bench.foreign.looking import draft, take_inventory
from bench.simulation.model import Simulation
from tests.docs.commands import ROOT

pytest.importorskip("fmpy", reason="FMPy is not installed")
pytestmark = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="there is no C compiler"
)
NAMES = {
    '"motor_velocity"': '"w_rel"',
    '"motor_acceleration"': '"a_rel"',
    '"simulated_motor_torque"': '"tau_drive"',
    '"friction_coulomb_f_c"': '"d_dry"',
}


@pytest.fixture
def joint(tmp_path: Path) -> Path:
    """An FMU whose author calls things by names of his own."""
    made = tmp_path / "ours.fmu"
    write_fmu(formulas_of(Simulation.load(ROOT / "docs/examples/rig_model.json")), made)
    target = tmp_path / "joint.fmu"
    with zipfile.ZipFile(made) as source, zipfile.ZipFile(target, "w") as out:
        for item in source.namelist():
            content = source.read(item)
            if item == "modelDescription.xml":
                for ours, theirs in NAMES.items():
                    content = content.replace(f"name={ours}".encode(), f"name={theirs}".encode())
            out.writestr(item, content)
    return target


def test_names_and_units_give_channels_and_each_guess_says_so(joint: Path, tmp_path: Path) -> None:
    found = take_inventory(joint)
    assert {variable.name: variable.channel for variable in found.variables if variable.channel} == {
        "w_rel": "motor_velocity",
        "a_rel": "motor_acceleration",
        "tau_drive": "motor_torque",
    }
    assert (found.version, found.kind) == ("3.0", "co-simulation")
    text = draft(found, tmp_path / "joint.toml", {"parameters.d_dry": {}})
    content = tomllib.loads(text)
    assert content["inputs"] == {"w_rel": "motor_velocity", "a_rel": "motor_acceleration"}
    assert content["outputs"] == {"tau_drive": "motor_torque"}
    assert content["parameters"] == {"d_dry": {}}
    assert text.count("a guess, from its name and unit") == 3
    assert '# "friction_viscous_f_v" = {}  # 0.0025 N*m*s/rad' in text


def test_the_mapping_is_taken_by_the_comparison(joint: Path) -> None:
    mapping = joint.with_name("mapping.toml")
    arguments = ["import", "--look", str(joint), "--mapping", str(mapping), "--set", "parameters.d_dry={}"]
    result = CliRunner().invoke(make_app(), arguments)
    assert result.exit_code == 0, result.output
    base = open_fmu(mapping)
    assert [(parameter.name, parameter.value) for parameter in base.free] == [("d_dry", 0.28)]
    time = np.arange(50) / 50.0
    given = {"time": time, "motor_velocity": np.full(50, 10.0), "motor_acceleration": np.zeros(50)}
    np.testing.assert_allclose(base.simulator.run(given, {})["motor_torque"], 0.28 + 0.025)


def test_a_misspelt_channel_of_an_input_is_said_with_the_likely_one(joint: Path) -> None:
    mapping = joint.with_name("mapping.toml")
    mapping.write_text(
        'fmu = "joint.fmu"\n[inputs]\nw_rel = "motor_velocty"\n[outputs]\ntau_drive = "motor_torque"\n', "utf-8"
    )
    given = {"time": np.arange(50) / 50.0, "motor_velocity": np.full(50, 10.0)}
    with pytest.raises(ConfigurationError, match=r"no channel 'motor_velocty'; did you mean 'motor_velocity'\?$"):
        open_fmu(mapping).simulator.run(given, {})


def test_an_input_that_nothing_was_guessed_for_is_said(joint: Path, tmp_path: Path) -> None:
    theirs = tmp_path / "theirs.fmu"
    with zipfile.ZipFile(joint) as source, zipfile.ZipFile(theirs, "w") as out:
        for item in source.namelist():
            content = source.read(item)
            out.writestr(item, content.replace(b'name="a_rel"', b'name="u2"').replace(b'unit="rad/s^2"', b""))
    arguments = ["import", "--look", str(theirs), "--mapping", str(tmp_path / "a.toml")]
    said = "inputs.u2 has no channel and stays at 0"
    assert said in CliRunner().invoke(make_app(), arguments).output.replace("\n", " ")
    arguments[-1:] = [str(tmp_path / "b.toml"), "--set", "inputs.u2=motor_acceleration"]
    result = CliRunner().invoke(make_app(), arguments)
    assert (result.exit_code, said in result.output) == (0, False)


def test_what_cannot_be_is_one_sentence(joint: Path, tmp_path: Path) -> None:
    found = take_inventory(joint)
    with pytest.raises(ConfigurationError, match=r"--set parameters\.nix: the FMU has no such variable.*d_dry"):
        draft(found, tmp_path / "x.toml", {"parameters.nix": {}})
    with pytest.raises(ConfigurationError, match=r"no output .* is called as a channel .*bench import --look joint"):
        open_fmu(joint)
    for text, sentence in {
        'fmu = "joint.fmu"\n[inptus]\n': r"inptus is no key there; keys are fmu, inputs, outputs, parameters, start",
        'fmu = "joint.fmu"\n[outputs.tau_drive]\nchannel = "motor_torque"\nunits = "N*m"': r"units is no key",
        'fmu = "joint.fmu"\n[outputs]\ntau = "motor_torque"': r"outputs\.tau: the FMU has no such variable",
        'fmu = "joint.fmu"\n[outputs]\ntau_drive = "torque"': r"outputs\.tau_drive: 'torque' is not compared",
        'fmu = "no.fmu"\n[outputs]\ntau_drive = "motor_torque"': r"wrong\.toml: fmu: there is no file 'no\.fmu' in",
    }.items():
        wrong = tmp_path / "wrong.toml"
        wrong.write_text(text, encoding="utf-8")
        with pytest.raises(ConfigurationError, match=sentence):
            open_fmu(wrong)
    target = tmp_path / "there.toml"
    target.write_text("kept = true\n", encoding="utf-8")
    result = CliRunner().invoke(make_app(), ["import", "--look", str(joint), "--mapping", str(target)])
    assert result.exit_code != 0
    assert target.read_text(encoding="utf-8") == "kept = true\n"
