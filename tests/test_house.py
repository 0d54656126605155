"""The house itself: what is registered can be loaded, pinned versions are the tested ones, skips are honest."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, entry_points, version
from pathlib import Path

import pytest

from tests.conftest import SLOW

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
GROUPS = PROJECT["project"]["entry-points"]


@pytest.mark.parametrize(("group", "name"), [(group, name) for group, names in GROUPS.items() for name in names])
def test_entry_points_load(group: str, name: str) -> None:
    installed = {entry.name: entry for entry in entry_points(group=group)}
    assert name in installed, "installed before it was added; install again"
    assert installed[name].value == GROUPS[group][name]
    assert installed[name].load() is not None


def test_places_of_slow_tests_exist() -> None:
    for beginning in SLOW:
        file, _, test = beginning.partition("::")
        assert (ROOT / file).exists(), f"tests/conftest.py calls {file} slow, which is not there"
        assert not test or f"def {test}(" in (ROOT / file).read_text("utf-8")


def test_slow_tests_are_left_out_on_request() -> None:
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", "not slow", "tests/docs/test_commands.py"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "test_every_page_is_in_the_index" in told
    assert "test_short_commands_run" not in told


def test_every_dependency_is_pinned() -> None:
    pinned = {_normal(re.split("==", pin)[0]) for pin in PROJECT["tool"]["uv"]["constraint-dependencies"]}
    extras = PROJECT["project"]["optional-dependencies"]
    wanted = [*PROJECT["project"]["dependencies"], *extras["test"], *extras["docs"], *extras["tdms"]]
    assert {_normal(re.split(r"[<>=!~ ;\[]", name)[0]) for name in wanted} <= pinned


def test_pins_allow_what_is_asked_for() -> None:
    asked = {
        _normal(m[1]): m[2]
        for text in PROJECT["project"]["dependencies"]
        if (m := re.match(r"([\w-]+)>=([\d.]+)", text))
    }
    for pin in PROJECT["tool"]["uv"]["constraint-dependencies"]:
        name, at = pin.split("==")
        if _normal(name) in asked:
            assert _numbers(at) >= _numbers(asked[_normal(name)]), pin


def test_the_program_knows_its_version() -> None:
    try:
        assert version("gearbench") == PROJECT["project"]["version"]
    except PackageNotFoundError:
        pytest.fail("the project is not installed")


@pytest.mark.parametrize(("required", "outcome"), [("1", "1 failed, 1 skipped"), ("0", "2 skipped")])
def test_wire_tests_do_not_skip_where_they_must_run(tmp_path: Path, required: str, outcome: str) -> None:
    (tmp_path / "conftest.py").write_text("from tests.conftest import pytest_runtest_makereport\n")
    (tmp_path / "test_it.py").write_text(
        "import pytest\n"
        "def test_wire(): pytest.skip('no veth pair can be made here')\n"
        "def test_other(): pytest.skip('the file is absent')\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(tmp_path), str(tmp_path)],
        env={**os.environ, "BENCH_REQUIRE_WIRE": required, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert outcome in done.stdout


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text))
