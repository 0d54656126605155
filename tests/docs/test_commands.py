"""Every command of the documentation is run, or, where that takes long, read by the program's own parser."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest
import typer.main

import fakes.concealed
from bench.cli.app import make_app
from bench.cli.exit_codes import MEANING
from tests.docs.commands import ELSEWHERE, LONG, PAGES, ROOT, Command, commands, mentions
from tests.program import bench

ALL = commands()
OURS = [command for command in ALL if not command.begins(ELSEWHERE)]
SHORT = [command for command in OURS if not command.begins(LONG)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clean folder in which the docs are where the commands expect them."""
    made = tmp_path_factory.mktemp("docs")
    (made / "docs").symlink_to(ROOT / "docs")
    return made


def test_tables_hold_nothing_that_is_gone() -> None:
    used = {command.begins(ELSEWHERE) or command.begins(LONG) for command in ALL}
    assert {*ELSEWHERE, *LONG} <= used


@pytest.fixture(scope="module")
def program() -> Any:
    """The program's own parser, made once."""
    return typer.main.get_command(make_app())


@pytest.mark.parametrize("command", [*OURS, *mentions()], ids=lambda c: f"{c.page}: {c.line}")
def test_the_program_knows_command_and_options(command: Command, program: Any) -> None:
    if command.words[0] == "python":
        assert (ROOT / command.words[1]).is_file()
        return
    assert command.words[0] == "bench"
    found = program
    words = command.words[1:]
    while hasattr(found, "commands") and words:
        assert words[0] in found.commands, f"there is no command bench {' '.join(words)}"
        found = found.commands[words.pop(0)]
    known = {option for parameter in found.params for option in (*parameter.opts, *parameter.secondary_opts)}
    assert {word for word in words if word.startswith("-")} <= known


@pytest.fixture(scope="module")
def ran() -> set[Command]:
    """Commands that ran in this process: a page's commands need those before them, which another process may have."""
    return set()


@pytest.mark.parametrize("command", SHORT, ids=lambda c: f"{c.page}: {c.line}")
def test_short_commands_run(command: Command, folder: Path, ran: set[Command], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    # bench stop speaks of what runs elsewhere on this computer; here only what the page does counts
    monkeypatch.setattr("bench.stop_button.find.elsewhere", list)
    before = SHORT[: SHORT.index(command)]
    for earlier in [*(c for c in before if c.page == command.page and c not in ran), command]:
        run(earlier)
        ran.add(earlier)


def run(command: Command) -> None:
    """Run a command where we are; it has to succeed."""
    if command.words[0] == "python":
        runpy.run_path(command.words[1], run_name="__main__")
        return
    done = bench(command.words[1:])
    assert done.code == 0, done.err or done.out
    if command.output is not None:
        Path(command.output).write_text(done.out, "utf-8")


def _anchors(page: Path) -> set[str]:
    """Anchors of a page: its headings as GitHub and mkdocs write them, and those set by hand."""
    text = page.read_text("utf-8")
    headings = (re.sub(r"[^\w\- ]", "", line.lower()) for line in re.findall(r"^#+ (.*)$", text, re.MULTILINE))
    return {heading.replace(" ", "-") for heading in headings} | set(re.findall(r'(?:id|name)="([^"]+)"', text))


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"], ids=lambda p: p.name)
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#\s]*)#?([^)\s]*)\)", page.read_text("utf-8")):
        found = page.parent / target if target else page
        assert found.exists(), f"{page.relative_to(ROOT)} links to {target}"
        assert not anchor or anchor in _anchors(found), f"{page.relative_to(ROOT)} links to {target}#{anchor}"


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs/index.md").read_text("utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert page.name == "index.md" or f"]({page.name})" in index, f"docs/index.md does not list {page.name}"


def test_the_folder_that_the_readme_analyses_is_the_one_with_an_effect() -> None:
    """Of those that the command before it makes."""
    (folder,) = {command.words[2] for command in ALL if command.line.startswith("bench mismatch hidden/")}
    concealed, _ = fakes.concealed.cases("quick", 1)
    assert concealed.strengths
    assert folder == f"hidden/seed-1/recordings/{concealed.alias}"


def test_readme_quotes_the_exit_codes() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    for code, meaning in MEANING.items():
        assert f"| {code.value} | {meaning} |" in text


def test_readme_quotes_the_example() -> None:
    example = (ROOT / "docs/examples/experiment.py").read_text("utf-8")
    readme = (ROOT / "README.md").read_text("utf-8")
    for line in readme.split("```python\n")[1].split("```")[0].splitlines():
        if line and not line.startswith(("run_campaign", "for recording")):
            assert line in example


def test_the_tutorial_for_scripts_quotes_the_example() -> None:
    example = (ROOT / "docs/examples/experiment.py").read_text("utf-8")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/scripts.md").read_text("utf-8"), re.DOTALL)
    assert len(blocks) == 4
    for line in "".join(blocks).splitlines():
        assert not line or line in example, line
