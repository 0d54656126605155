"""The house itself: what is registered can be loaded, pinned versions are the tested ones, skips are honest."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import PackageNotFoundError, entry_points, version
from pathlib import Path

import pytest

from tests import units
from tests.conftest import REQUIRE_WIRE, SLOW

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


def test_slow_tests_are_left_out_on_request(pytester: pytest.Pytester) -> None:
    pytester.makeconftest("from tests.conftest import pytest_collection_modifyitems")
    file, _, name = next(beginning for beginning in SLOW if "::" in beginning).partition("::")
    (pytester.path / file).parent.mkdir(parents=True)
    (pytester.path / file).write_text(f"def {name}(): pass\ndef test_other(): pass\n")
    marked = ("-p", "no:cacheprovider", "-o", "markers=slow")
    pytester.runpytest_inprocess(*marked, "-m", "not slow").assert_outcomes(passed=1, deselected=1)
    pytester.runpytest_inprocess(*marked).assert_outcomes(passed=2)


def test_places_of_tests_that_begin_first_exist() -> None:
    for beginning in units.FIRST:
        assert (ROOT / beginning.partition("::")[0]).exists(), f"tests/units.py names {beginning}, which is not there"


def test_what_shares_a_fixture_or_needs_an_earlier_command_is_one_unit() -> None:
    commands = "tests/docs/test_commands.py::test_short_commands_run["
    assert units.unit("tests/bench/twin/test_watch.py::test_a") == units.unit("tests/bench/twin/test_page.py::test_b")
    assert units.unit(f"{commands}README.md: bench plan quick]") == units.unit(f"{commands}README.md: bench run: a]")
    assert units.unit(f"{commands}README.md: bench plan quick]") != units.unit(f"{commands}docs/twin.md: bench plan]")
    assert units.unit("tests/bench/test_api.py::test_a[b::c]") == "tests/bench/test_api.py"
    row = "tests/bench/matrix/test_matrix.py::test_row"
    assert units.unit(f"{row}[a]") != units.unit(f"{row}[b]")


def test_long_units_begin_before_short_ones() -> None:
    order = [
        "tests/browser/test_operator.py::test_a",
        "tests/system/test_rig.py::test_b",
        "tests/bench/test_api.py::test_c",
    ]
    assert [units.rank(test) for test in order] == sorted({units.rank(test) for test in order})
    assert units.rank(order[-1]) == len(units.FIRST)


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


@pytest.mark.parametrize(("required", "outcome"), [("1", {"failed": 1, "skipped": 1}), ("0", {"skipped": 2})])
def test_wire_tests_do_not_skip_where_they_must_run(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, required: str, outcome: dict[str, int]
) -> None:
    monkeypatch.setenv(REQUIRE_WIRE, required)
    pytester.makeconftest("from tests.conftest import pytest_runtest_makereport")
    pytester.makepyfile(
        "import pytest\n"
        "def test_wire(): pytest.skip('no veth pair can be made here')\n"
        "def test_other(): pytest.skip('the file is absent')\n"
    )
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes(**outcome)


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text))
