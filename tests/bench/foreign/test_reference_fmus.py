"""The Reference FMUs of the FMI project (github.com/modelica/Reference-FMUs, 2-clause BSD), as a compatibility test.

They are not part of this project: ``pytest tests/bench/foreign/test_reference_fmus.py --fmus DIR`` with a folder that
holds them, of FMI 2.0, 3.0 or both. Without one the tests are skipped and say so.
"""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench.foreign.fmu import Fmu, unpack_fmu
from bench.foreign.mapping import Mapping
from bench.simulation.frame import FloatArray

NAMES = ("VanDerPol", "Dahlquist", "BouncingBall")
GRAVITY, FALL_S = 9.81, 0.4


@pytest.fixture
def folder(request: pytest.FixtureRequest) -> Path:
    option = request.config.getoption("--fmus")
    if option is None:
        pytest.skip("no folder of the Reference FMUs is given: --fmus DIR")
    pytest.importorskip("fmpy")
    return Path(str(option))


def files(folder: Path, name: str) -> list[Path]:
    """The FMUs of a name, of whatever FMI version."""
    found = sorted(folder.rglob(f"{name}.fmu"))
    assert found, f"{folder} holds no {name}.fmu"
    return found


def run(path: Path, kind: str, variable: str, time: FloatArray) -> FloatArray:
    """A variable of an FMU; it stands for a torque, which needs no inputs."""
    content = {"fmu": path.name, "type": kind, "outputs": {variable: {"channel": "motor_torque", "unit": "N*m"}}}
    fmu = Fmu(str(path), str(path.resolve()), Mapping.model_validate(content))
    return fmu.run({"time": time}, {})["motor_torque"]


def reference(path: Path) -> dict[str, FloatArray]:
    """What the FMU's authors say it gives in co-simulation, from the FMU itself."""
    with zipfile.ZipFile(path) as archive:
        name = next(n for n in archive.namelist() if n.endswith("_out.csv"))
        head, *rows = csv.reader(io.StringIO(archive.read(name).decode("utf-8")))
    values = np.array(rows, dtype=np.float64)
    return {heading.strip('"'): values[:, k] for k, heading in enumerate(head)}


@pytest.mark.parametrize("name", NAMES)
def test_co_simulation_gives_what_its_authors_say(folder: Path, name: str) -> None:
    for path in files(folder, name):
        expected = reference(path)
        time = expected.pop("time")
        variables = {v.name for v in unpack_fmu(str(path.resolve()))[1].modelVariables if v.causality == "output"}
        for variable in variables & set(expected):
            simulated = run(path, "co-simulation", variable, time)
            np.testing.assert_allclose(simulated, expected[variable], atol=1e-9, err_msg=f"{path}: {variable}")


def _van_der_pol(time: FloatArray) -> FloatArray:
    def slope(_: float, x: FloatArray) -> list[float]:
        return [x[1], (1.0 - x[0] ** 2) * x[1] - x[0]]

    return np.asarray(solve_ivp(slope, (0.0, time[-1]), [2.0, 0.0], t_eval=time, rtol=1e-9, atol=1e-9).y[0])


SOLVED: dict[str, tuple[str, float, Callable[[FloatArray], FloatArray]]] = {
    "VanDerPol": ("x0", 10.0, _van_der_pol),
    "Dahlquist": ("x", 10.0, lambda time: np.exp(-time)),
    # before it meets the ground
    "BouncingBall": ("h", FALL_S, lambda time: 1.0 - 0.5 * GRAVITY * time**2),
}


@pytest.mark.parametrize("name", NAMES)
def test_model_exchange_gives_the_solution_of_its_equations(folder: Path, name: str) -> None:
    variable, until, solution = SOLVED[name]
    time = np.arange(0.0, until + 1e-9, 0.01)
    for path in files(folder, name):
        simulated = run(path, "model-exchange", variable, time)
        np.testing.assert_allclose(simulated, solution(time), atol=2e-3, err_msg=str(path))
