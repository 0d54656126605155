"""The page: one file, the verdict first, a plot for each finding, nothing from names unescaped, no figure made up."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from bench.mismatch.discovery import Discovery
from bench.mismatch.report import reasons
from bench.mismatch.report.content import Compared
from bench.mismatch.report.finding import conclude
from bench.mismatch.report.left_out import LeftOut, table
from bench.mismatch.report.page import page
from bench.mismatch.report.plots import _amplitudes
from bench.mismatch.report.report import Report
from tests.bench.mismatch.report import made


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href")]


def _report(
    *found: Discovery, frame: Any = None, held: Any = made.HELD_OUT, sigma: float = 0.02, **more: Any
) -> Report:
    frame = made.campaign() if frame is None else frame
    channel = found[0].channel if found else "motor_torque"
    own = made.outcome(frame, channel, list(found), sigma, held)
    data = made.dataset(frame, channel, own.rows, held=held)
    findings = conclude([own], data)
    left = [LeftOut("friction.coulomb", "Coulomb <friction>", "motor_torque", "named", confidence=0.98)]
    verdict = "mismatch" if findings else "match"
    values = {"simulation": Compared("model", "<model>.json", ("friction.coulomb.f_c",))} | more
    return Report(verdict, "", data, [own], findings, ["a <note>"], left, **values)


def _stribeck(**more: Any) -> Discovery:
    frame = made.campaign()
    alternatives = (
        made.alternative("friction.viscous_quadratic", None),
        made.alternative("unknown", np.zeros(frame.size), True),
    )
    added = made.stribeck(frame)
    return made.discovery("motor_torque", "friction.stribeck", added, ("speed",), alternatives=alternatives, **more)


def test_the_page_stands_alone() -> None:
    text = page(_report(_stribeck()))
    reader = _Reader()
    reader.feed(text)
    assert all(link.startswith(("data:", "#")) for link in reader.links)
    assert "http://" not in re.sub(r'(xmlns(:\w+)?|rdf:resource)="[^"]*"|"http://www.w3.org[^"]*"', "", text)
    assert reader.tags.count("article") == 2
    # what is left against the noise, and the finding; the latter can be saved
    assert reader.tags.count("svg") == 2
    assert sum(link.startswith("data:image/svg+xml;base64,") for link in reader.links) == 1
    assert "currentColor" in text
    assert "prefers-color-scheme:dark" in text


@pytest.fixture(name="undrawn")
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the plots out: they take a second each."""
    monkeypatch.setattr("bench.mismatch.report.page.plot", lambda *_: "")


@pytest.mark.usefixtures("undrawn")
def test_names_are_escaped() -> None:
    text = page(_report(_stribeck()))
    for name in ("<note>", "<odd>", "<ends>", "<model>", "<alternative>", "<friction>"):
        assert name not in text
        assert name.replace("<", "&lt;").replace(">", "&gt;") in text


@pytest.mark.usefixtures("undrawn")
def test_it_says_verdict_equation_values_evidence_and_why_not_another() -> None:
    report = _report(_stribeck())
    text = page(report)
    assert report.sentence.startswith("Mismatch: the simulation leaves out Stribeck friction (motor torque: below")
    for told in (
        "<b>Mismatch:</b>",
        "f_s",
        "400 ± 20",
        "mN·m",
        "Why not another",
        "have been found?",
        "Strongest in r0",
    ):
        assert told in text
    share = report.findings[0].share_of_excess
    assert share is not None
    assert f"{100.0 * share:.0f} % of the energy above the noise" in text
    assert "not computed, because it was compared by predictive densities only" in text


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"confidence": None}, "no calibration of confidences covers such a finding"),
        ({"p_value": None}, "no surrogates were drawn for it"),
        ({"parameters": ({"symbol": "c", "value": 1.0, "unit": "1", "std": None},)}, "it was chosen, not fitted"),
    ],
)
def test_a_figure_that_is_not_there_is_told_with_the_reason(change: dict[str, Any], why: str) -> None:
    text = page(_report(_stribeck(**change)))
    assert "not computed, because" in text
    assert why in text


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(("as_good", "why"), [(True, reasons.A_NAME_IS_LIKELIER), (False, reasons.NO_CONFIDENCE)])
def test_something_without_a_name_has_no_confidence_where_a_name_is_likelier(as_good: bool, why: str) -> None:
    other = made.alternative("friction.stribeck", None, as_good)
    added = made.stribeck(made.campaign())
    found = made.discovery("motor_torque", "unknown", added, ("speed",), alternatives=(other,), confidence=None)
    text = page(_report(found))
    assert [reason for reason in (reasons.A_NAME_IS_LIKELIER, reasons.NO_CONFIDENCE) if reason in text] == [why]


@pytest.mark.usefixtures("undrawn")
def test_where_nothing_is_held_out_the_page_says_so() -> None:
    text = page(_report(_stribeck(), held=()))
    assert "no recording could be held out" in text
    assert "none of them held out" in text
    assert "Residual of what was fitted" in text


@pytest.mark.usefixtures("undrawn")
def test_it_opens_with_three_lines_and_a_picture() -> None:
    text = page(_report(_stribeck()))
    opened = text[text.index('class="verdict') : text.index("</svg>")]
    assert opened.count("<p>") == 3
    assert "Left on recordings held out: motor torque" in opened
    assert "Findings: 1 named" in opened
    assert opened.count("<rect") == 2


@pytest.mark.usefixtures("undrawn")
def test_the_equation_is_typeset_and_its_symbols_are_explained() -> None:
    text = page(_report(_stribeck(equation="tau_m += d * f_s * exp(-(abs(w_m)/w_s)**delta)")))
    assert "<math>" in text
    assert "<msub><mi>ω</mi><mtext>m</mtext></msub>" in text
    assert "speed of the motor" in text
    assert "tau_m +=" not in text


@pytest.mark.usefixtures("undrawn")
def test_no_figure_that_is_none_stands_on_the_page() -> None:
    odd = ({"symbol": "c", "value": float("nan"), "unit": "rad", "std": float("inf")},)
    text = re.sub(r"<[^>]*>", " ", page(_report(_stribeck(parameters=odd))))
    assert not re.search(r"\b(nan|inf)\b", text)
    assert "the recordings do not determine it" in text


@pytest.mark.usefixtures("undrawn")
def test_a_match_and_an_undetermined_folder_have_their_page() -> None:
    match = _report()
    assert match.sentence.startswith("Match: what the calibrated simulation leaves of motor torque")
    assert 'class="verdict match"' in page(match)
    nothing = Report("undetermined", "too <little>", match.data)
    text = page(nothing)
    assert 'class="verdict undetermined"' in text
    assert "<article>" not in text
    assert "too &lt;little&gt;" in text


def test_orders_have_a_table_and_a_spectrum() -> None:
    frame = _turning()
    added = 1e-5 * np.sin(46.0 * frame.theta + 0.3)
    rows = ({"order": 46.0, "amplitude": 1e-5, "part": "<disc>", "load": True}, {"order": 50.0, "amplitude": None})
    found = made.discovery("transmission_error", "te.harmonic", added, ("angle",), orders=(46.0,), table=rows)
    report = _report(found, frame=frame, sigma=1e-5)
    text = page(report)
    assert "&lt;disc&gt;" in text
    assert "order per output revolution" in text
    assert "–</td>" in text
    own = report.outcomes[0]
    before, after = (_amplitudes(own, values) for values in (own.left + added, own.left))
    assert before is not None
    assert after is not None
    assert before[46] == pytest.approx(1e-5, rel=0.1)
    assert after[46] < 1e-6


def _turning() -> Any:
    from dataclasses import replace

    frame = made.campaign(each=5000)
    angle = 1.3e-3 * np.arange(5000)
    theta = np.concatenate([angle * np.sign(frame.velocity[k * 5000]) for k in range(20)])
    return replace(frame, theta=theta, q=theta)


@pytest.mark.parametrize(
    ("channel", "effect", "variables", "more", "label"),
    [
        ("transmission_error", "te.local_defect", ("angle",), {"angle_windows": ((1.0, 1.01),)}, "output angle / deg"),
        ("temperature", "thermal.sensor_lag", ("transient",), {}, "recording r"),
        ("motor_torque", "friction.run_in", ("time",), {}, "campaign began / h"),
        ("motor_torque", "unknown", (), {}, "campaign began / h"),
        ("motor_torque", "friction.presliding", ("since_reversal",), {}, "start or reversal"),
        ("load_torque", "sensor.torque_gain", ("load_motor_torque",), {}, "load motor's torque"),
    ],
)
def test_a_plot_for_each_kind(
    channel: str, effect: str, variables: tuple[str, ...], more: dict[str, Any], label: str
) -> None:
    frame = _turning() if channel == "transmission_error" else made.campaign()
    found = made.discovery(channel, effect, 0.3 * np.sin(frame.time), variables, **more)
    text = page(_report(found, frame=frame))
    assert "<svg" in text
    assert label.replace("'", "&#x27;") in text or label in text


def test_terms_left_out_make_a_table() -> None:
    rows = [LeftOut("a.b", "A", "motor_torque", "not found", rmse_without=0.2, rmse_found=None, why="too little")]
    assert table(rows).splitlines()[-1] == "| `a.b` | motor_torque | not found | 0.2 → – | – | too little |"
