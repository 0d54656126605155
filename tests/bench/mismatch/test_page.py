"""The page: one file, the verdict first, a plot before and after for each finding, readable light and dark."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest

from bench.mismatch.assess import assess
from bench.mismatch.given import Given
from bench.mismatch.leave_one_out import LeftOut
from bench.mismatch.page import page, sentence
from bench.mismatch.run import Report
from bench.simulation.model import Simulation
from tests.bench.mismatch.synthetic import effect, torques


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href")]


@pytest.fixture(scope="module", name="report")
def _report() -> Report:
    data = torques(lambda f: effect("friction.stribeck", "motor_torque", "gaussian", f, (0.3,), (8.0,)))
    found = assess(data, Given.of(Simulation.nominal()), ("motor_torque", "load_torque"))
    left = [LeftOut("friction.coulomb", "Coulomb friction", "motor_torque", "named", confidence=0.98)]
    return Report("mismatch", "", data, found.scores, found.findings, found.analysis, ["a <note>"], left)


def test_the_page_stands_alone(report: Report) -> None:
    text = page(report)
    reader = _Reader()
    reader.feed(text)
    assert all(link.startswith(("data:", "#")) for link in reader.links)
    assert "http://" not in re.sub(r'(xmlns(:\w+)?|rdf:resource)="[^"]*"|"http://www.w3.org[^"]*"', "", text)
    assert reader.tags.count("article") == len(report.findings) + 1
    assert reader.tags.count("svg") == len(report.findings)
    assert "currentColor" in text
    assert "prefers-color-scheme:dark" in text
    assert "a &lt;note&gt;" in text


def test_it_says_verdict_equation_values_evidence_and_why_not_another(report: Report) -> None:
    text = page(report)
    assert sentence(report).startswith("Mismatch: the simulation leaves out Stribeck friction")
    for told in ("<b>Mismatch:</b>", "f_s", "N*m", "before: without it", "Why not another", "have been found?"):
        assert told in text
    assert re.search(r"0\.30\d* ± ", text)


def test_a_match_and_an_undetermined_folder_have_their_page(report: Report) -> None:
    for verdict, why in (("match", ""), ("undetermined", "too little")):
        text = page(Report(verdict, why, report.data))
        assert f'class="verdict {verdict}"' in text
        assert "<article>" not in text
