"""Commands of the documentation: lines of fenced ``sh`` and ``console`` blocks, and those no test runs, with why."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
_BLOCK = re.compile(r"^```(?:sh|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(r"`(bench [a-z][^`]*)`")

ELSEWHERE = {
    "python3 -m venv": ".ci/run runs the README's two commands",
    ". .venv/bin/activate": "sets up a shell, not a program",
    ".ci/run": "runs this test",
    "pip install -q -e": ".ci/run installs the extra and builds the site",
    "ip link add": "needs rights; tests/veth.py makes such a pair",
    "ip link set": "needs rights; tests/veth.py does it",
    "sysctl net.": "setting of a host",
    "ethtool -C": "setting of a network card",
}
"""Beginnings of lines that are not ours to run."""

LONG = {
    "bench import docs/examples/emps.toml --data FOLDER": "needs the measured files, which a test of leave-one-out has",
    "bench import --ask": "asks; tests/bench/importing/test_looking.py answers",
    "bench mismatch emps": "needs the import above",
    "bench run paper": "minutes; bench benchmark campaign measures it",
    "bench identify paper": "needs the campaign above",
    "bench mismatch paper": "needs the campaign above",
    "bench benchmark identify paper": "needs the campaign above",
    **{
        f"bench prove --{option}": "minutes; bench prove --quick runs in its own tests"
        for option in ("set", "held-back", "clutter", "severity", "peers", "quick", "criteria")
    },
    "bench prove --through-the-bench": "minutes a folder; tests/bench/proof/through does one in process",
    "bench trend recordings": "needs campaigns of a gearbox; tests/bench/trend has them",
    "bench mismatch mine": "needs the folder that bench serve --conceal makes",
    "bench prove --open 77 --sealed mine": "needs that folder; tests/fakes/sealed opens one",
    "bench prove --real": "needs recordings of others, and minutes; tests/bench/proof/real has what needs none",
    "bench mismatch hidden/seed-1/recordings/e9339ad6d5a4 --out": "tests/bench/mismatch/test_end_to_end.py does it",
    "python docs/examples/mismatch_pictures.py": "needs the folder above, and draws the pictures of the docs",
    "bench investigate mine": "needs the folder that bench serve --conceal makes; tests/bench/investigate does it",
    "bench benchmark investigate": "minutes a plant; tests/bench/investigate does one experiment",
    "bench benchmark twin": "minutes to hours; tests/bench/twin has campaigns with a change and without",
    "bench serve": "runs until it is stopped; tests/browser and tests/bench/service do it",
    "bench emulate": "runs until it is stopped; tests/fakes/ethercat/wire does it",
    "bench commission --b": "needs a wire or hardware; tests/bench/commissioning does it in process",
    "bench run quick --bus": "needs rights and real time; tests/drivers/test_wire.py does it",
    "bench run short --bench rh380n-wire": "the same; tests/system/test_wire_modbus.py opens that bench",
    "bench validate wired": "needs the run above",
    "bench identify wired": "needs the run above",
    "bench benchmark cycle": "minutes, and rights; tests/system/test_benchmark_cycle.py does it",
    "bench doctor --bus": "needs an interface; tests/bench/cli/test_doctor.py does it without",
    "bench run quick --bench lab.toml": "the same run once more, or hardware",
}
"""Beginnings of lines of which only name, options and arguments are checked."""


@dataclass(frozen=True)
class Command:
    """One line, and the page it stands on."""

    page: str
    line: str

    @property
    def words(self) -> list[str]:
        """The line as a shell would split it, without comment and without redirection of the output."""
        return shlex.split(self.line.split(" > ")[0], comments=True)

    @property
    def output(self) -> str | None:
        """The file that its output goes to, or None."""
        return self.line.split(" > ")[1].strip() if " > " in self.line else None

    def begins(self, table: dict[str, str]) -> str | None:
        """Return the beginning in ``table`` that fits, or None."""
        return next((start for start in table if self.line.startswith(start)), None)


def mentions() -> list[Command]:
    """Return the commands that stand in running text, such as ``bench run paper``."""
    return [
        Command(str(page.relative_to(ROOT)), line)
        for page in PAGES
        for line in sorted(set(_INLINE.findall(_FENCED.sub("", page.read_text("utf-8")))))
    ]


def commands() -> list[Command]:
    """Return all commands in the order of pages and lines."""
    found = []
    for page in PAGES:
        for block in _BLOCK.findall(page.read_text("utf-8")):
            lines = (line.removeprefix("$ ").split("  #")[0].strip() for line in block.splitlines())
            found += [Command(str(page.relative_to(ROOT)), line) for line in lines if line and not line.startswith("#")]
    return found
