"""What goes out does what our own prediction does: C and FMUs compiled and run, Modelica as text."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.exchange import to_fmu
from bench.exchange.export import WRITERS
from bench.exchange.written import formulas_of
from bench.foreign.fmu import open_fmu
from bench.simulation.frame import FloatArray
from bench.simulation.model import Simulation
from tests.bench.exchange.samples import STANDSTILL, inputs, name_of, ours, with_rows
from tests.bench.exchange.test_written import MADE

COMPILER = any(shutil.which(name) for name in ("cc", "gcc", "clang"))
needs_compiler = pytest.mark.skipif(not COMPILER, reason="there is no C compiler")
CHANNELS = ("transmission_error", "motor_torque", "temperature")


def model() -> Simulation:
    """Series, a table and a formula of what was recorded beside, states that were not, a memory, heat."""
    return with_rows(
        *MADE["series"],
        MADE["table"][0] | {"also": [*MADE["formula"], *MADE["states"]]},
        {"effect": "friction.coulomb", "parameters": {"f_c": {"value": 0.4, "unit": "N*m"}}},
        {
            "effect": "friction.presliding",
            "form": "lugre_kept",
            "point": [2.0, 0.5, 8.0],
            "parameters": {"f_d": 0.3, "s_d": 2.0, "b_s": 0.5, "w_s": 8.0},
        },
        {"effect": "thermal.loss_heating", "parameters": {"1/C": {"value": 2e-5, "unit": "K/J"}}},
    )


def check(exported: dict[str, FloatArray]) -> None:
    for channel in CHANNELS:
        predicted = ours(model(), channel, 25.0)
        np.testing.assert_allclose(
            exported[channel], predicted, rtol=1e-9, atol=1e-11 * np.abs(predicted).max(), err_msg=channel
        )


MAIN = """#include "model.h"
#include <stdio.h>
int main(void)
{
    Model m; double t, u[INPUTS], y[OUTPUTS];
    model_begin(&m);
    while (scanf("%lf", &t) == 1) {
        for (int i = 0; i < INPUTS; i++) if (scanf("%lf", &u[i]) != 1) return 1;
        model_step(&m, t, u, y);
        for (int i = 0; i < OUTPUTS; i++) printf("%.17g ", y[i]);
    }
    return 0;
}
"""


@needs_compiler
def test_c_does_what_the_prediction_does(tmp_path: Path) -> None:
    formulas = formulas_of(model(), STANDSTILL)
    WRITERS["c"](formulas, tmp_path, "model", "")
    (tmp_path / "main.c").write_text(MAIN, encoding="utf-8")
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
    subprocess.run([to_fmu.compiler(), *strict, "model.c", "main.c", "-lm", "-o", "run"], cwd=tmp_path, check=True)
    given = inputs()
    rows = np.column_stack([given["time"], *(given[n] for n in formulas.inputs)])
    text = "\n".join(" ".join(repr(float(v)) for v in row) for row in rows)
    done = subprocess.run([tmp_path / "run"], input=text, capture_output=True, text=True, check=True)
    values = np.array(done.stdout.split(), dtype=np.float64).reshape(-1, len(formulas.outputs)).T
    check({c: values[list(formulas.outputs).index(name_of(c))] for c in CHANNELS})


@needs_compiler
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_fmu_is_valid_and_does_what_the_prediction_does(tmp_path: Path, version: str) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="FMPy is not installed")
    model().save(tmp_path / "joint.json")
    arguments = ["export-model", str(tmp_path / "joint.json"), "--to", "fmu", "--fmi", version, "--json"]
    result = CliRunner().invoke(make_app(), [*arguments, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    (file,) = json.loads(result.output)["files"]
    assert validation.validate_fmu(file) == []
    mapping = tmp_path / "joint.toml"
    rows = [f'"{name}" = "{name}"' for name in json.loads(result.output)["inputs"]]
    outputs = [f'{name_of(c)} = "{c}"' for c in CHANNELS]
    mapping.write_text("\n".join(['fmu = "joint.fmu"', "[inputs]", *rows, "[outputs]", *outputs]), encoding="utf-8")
    check(open_fmu(mapping).simulator.run(inputs(), {}))
    # a coefficient is a parameter
    other = open_fmu(mapping).simulator.run(inputs(), {"friction_coulomb_f_c": 0.5})["motor_torque"]
    change = other - ours(model(), "motor_torque", 25.0)
    np.testing.assert_allclose(change, 0.1 * np.sign(inputs()["motor_velocity"]), atol=1e-9)


def test_without_a_compiler_it_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(ConfigurationError, match="there is no C compiler here"):
        WRITERS["fmu"](formulas_of(model()), tmp_path, "joint", "2.0")


def test_modelica_has_all_of_it(tmp_path: Path) -> None:
    (file,) = WRITERS["modelica"](formulas_of(model()), tmp_path, "joint", "")
    text = file.read_text(encoding="utf-8")
    assert text.startswith("block Joint ")
    assert text.rstrip().endswith("end Joint;")
    for fragment in (
        "friction_coulomb_f_c = 0.4",
        "look_up({3, 2}",
        ":= relaxing(pre(",
        ":= integral(pre(",
        "input Real aux_pressure",
    ):
        assert fragment in text


def test_what_the_recordings_did_not_show_is_left_out_and_told() -> None:
    # a rig without a load cell and a thermometer: its friction has numbers, what hangs on load and heat has none
    content = {"format": "bench-simulation", "format_version": "1.0", "gearbox": {"ratio": 1.0}}
    coulomb = {"effect": "friction.coulomb", "parameters": {"f_c": {"value": 0.4, "unit": "N*m"}}}
    formulas = formulas_of(Simulation.from_json(content | {"terms": [coulomb]}), STANDSTILL)
    assert list(formulas.outputs) == ["simulated_motor_torque"]
    (note,) = formulas.notes
    assert note.startswith("motor_torque is without friction.viscous, friction.viscous_temperature_linear")
    assert any(why.startswith("load_torque is left out: the simulation has no numbers for") for why in formulas.refused)
    with pytest.raises(ConfigurationError, match=r"nothing can be exported: .* has no numbers for friction\.coulomb"):
        formulas_of(Simulation.from_json(content | {"terms": []}))
