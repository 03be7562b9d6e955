"""The page that a report writes: complete by itself, with evidence for every verdict."""

import re
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
import sympy
from loop_systems import oscillator

import pysindy_evolve as pse
from pysindy_evolve.equations import AlgebraicEquations, Equations
from pysindy_evolve.export.mathml import equations_mathml, expression_mathml
from pysindy_evolve.loop.facts.effect import Alternative
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import ONE, call, constant, sub, variable

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
VOID = {"meta", "br", "hr", "img", "link"}


class Outline(HTMLParser):
    """Headings and their order; raises where tags are not closed in turn."""

    def __init__(self):
        super().__init__()
        self.open, self.headings, self.addresses = [], [], []

    def handle_starttag(self, tag, attrs):
        self.addresses += [v for k, v in attrs if k in ("src", "href", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.headings.append(data.strip())


def page_of(report, tmp_path, **options):
    path = tmp_path / "new folder" / "report.html"
    report.to_html(path, **options)
    return path.read_text(encoding="utf-8")


@pytest.fixture
def page(report, tmp_path):
    return page_of(report, tmp_path, units={"q": "m", "v": "m/s", "t": "s"})


def test_page_is_well_formed_and_goes_from_equations_to_settings(page):
    outline = Outline()
    outline.feed(page)
    assert outline.open == []
    assert outline.headings == [
        "Equations",
        "Errors on held-out data",
        "What was missing",
        "What remains",
        "Where the residual lives",
        "Data and settings",
    ]


def test_settings_have_the_unit_of_time(page):
    assert "cycles per s<" in page
    assert "per unit of t" not in page


def test_page_needs_nothing_from_outside(page):
    outline = Outline()
    outline.feed(page)
    assert all(address.startswith(("#", "data:")) for address in outline.addresses)
    assert "<script" not in page
    assert "@import" not in page
    assert re.findall(r"url\((?!#)", page) == []


def test_page_shows_errors_evidence_and_a_picture_of_the_twins_for_each_effect(report, page):
    for effect in report.effects:
        assert f"{effect.name} <span" in page
        assert f"p = {effect.p_value:.2g}" in page
        assert f"Scores of twins of {effect.name}" in page
    assert page.count("<svg") >= len(report.effects) + 1
    for errors in (report.before, report.after):
        assert f"<td>{errors.derivative_error[1]:.3g}</td>" in page


def test_names_in_the_pictures_are_not_shared_between_them(page):
    pictures = re.findall(r"<svg.*?</svg>", page, flags=re.DOTALL)
    clips = [set(re.findall(r'<clipPath id="(.*?)"', picture)) for picture in pictures]
    assert all(clips)
    assert len(set().union(*clips)) == sum(map(len, clips))


def test_complete_page_gives_the_best_that_did_not_pass_and_its_twins(complete, tmp_path):
    page = page_of(complete, tmp_path)
    assert "What was missing" not in page
    names = " and ".join(one.name for one in complete.rejected.tried.group)
    assert f"the best one left, {names} together in the equation of v, is matched" in page
    assert f"p = {complete.rejected.p_value:.2g}" in page
    assert "Scores of twins and of the best effect that did not pass" in page


def test_same_report_gives_the_same_page(complete, tmp_path):
    assert page_of(complete, tmp_path) == page_of(complete, tmp_path)


@pytest.mark.slow
def test_page_gives_the_coefficient_of_another_form_but_no_chance(report, tmp_path):
    """Of the same effect in another form nothing was tested: it is told by no p."""
    (first, *others), v = report.effects, sympy.Symbol("v", real=True)
    rounded = Alternative(first.name, first.state, sympy.tanh(v), 0.61, (), force=3 * sympy.tanh(v))
    other = replace(rounded, name="quadratic drag")
    for rival, is_tested in ((rounded, False), (other, True)):
        told = replace(report, effects=(replace(first, rivals=(rival,)), *others))
        page = page_of(told, tmp_path)
        assert ("(p = 0.61)" in page) is is_tested
        assert "<mn>3</mn>" in page[page.index("cannot tell it from") :]


def test_page_says_what_to_measure_next_where_effects_cannot_be_told_apart(tmp_path):
    rubbed = oscillator("Coulomb friction", "- 2*sgn(v)")
    record = rubbed.record(noise=0.02)
    report = pse.close_loop(rubbed.model, record, operators=(), random_state=0)
    page = page_of(report, tmp_path)
    assert "What to measure next" in page
    assert "the same in another form" in page
    assert "### What to measure next" in report.to_markdown()


def test_page_without_jinja_names_the_extra(report, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(ImportError, match=r"pip install \"pysindy-evolve\[report\]\""):
        report.to_html(tmp_path / "report.html")


def test_equations_break_between_terms_and_keep_powers_of_ten():
    q = variable(0).parts[0][1]
    model = Equations((q, ONE), np.array([[-2.18e6, 3.0]]), ("q",))
    ((left, first, last),) = equations_mathml(model)
    assert "<mi>q</mi>" in left
    assert "<mn>2.18</mn><mo>·</mo><msup><mn>10</mn><mn>6</mn></msup>" in first
    assert "−" in first
    assert last.endswith("<mn>3</mn></math>")


def test_the_left_side_of_a_force_has_no_dot():
    q = variable(0).parts[0][1]
    settings = ((q,), np.array([[2.0]]), ("F",))
    (moving,), (algebraic,) = (
        equations_mathml(kind(*settings)) for kind in (Equations, AlgebraicEquations)
    )
    assert "˙" in moving[0]
    assert "˙" not in algebraic[0]


def test_signs_are_sgn_and_exponentials_stay_beside_them():
    v = sympy.Symbol("v", real=True)
    shown = expression_mathml(sympy.sign(v) * sympy.exp(-(v**2) / 4))
    assert shown.index("<mi>sgn</mi>") < shown.index("<mi>exp</mi>")
    assert "mfrac" not in shown.split("exp")[0]


def test_an_input_at_an_earlier_time_keeps_its_capital():
    t = sympy.Symbol("t", real=True)
    shown = expression_mathml(sympy.Function("F", real=True)(t - 0.04))
    assert "<mi>F</mi>" in shown
    assert "<mi>f</mi>" not in shown


def test_the_sign_of_an_odd_function_is_not_lost_between_two_terms():
    inside = sub(constant(1.0), variable(0))
    (term,) = (product for _, product in call(BUILTIN["tanh"], inside).parts)
    ((_, first, second),) = equations_mathml(Equations((term, ONE), np.array([[3.0, 2.0]]), ("q",)))
    assert first.startswith('<math><mo form="prefix">−</mo><mn>3</mn>')
    assert first.count("−") == 2  # its own, and that of q - 1
    assert second.endswith("<mn>2</mn></math>")


def test_the_dot_of_a_rate_stands_above_the_letter_and_not_above_its_index():
    q = variable(0).parts[0][1]
    ((left, _),) = equations_mathml(Equations((q,), np.array([[2.0]]), ("u_level",)))
    assert "<msub><mover><mi>u</mi><mo>˙</mo></mover><mi>level</mi></msub>" in left
