"""The report as one self-contained page of HTML: no script, no network."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from io import StringIO
from typing import Any

import numpy as np

from ...export.mathml import equations_mathml, expression_mathml
from ..facts.effect import Alternative, Effect
from ..facts.outcome import Outcome
from .advice import paragraphs
from .effect_text import (
    hardly_named,
    in_equation,
    meant,
    name_of_alternative,
    named_together,
    numbers_inside,
    pumped,
    whose_share,
    with_sign,
    without_rivals,
)
from .experiment import plan
from .number_text import check_units, ends, value_within, with_unit
from .printed_names import as_printed
from .remains import remains
from .text import free_parameters, note_on_shared_terms, p_of_effects, table_cells
from .verdict import verdict_of


def as_html(outcome: Outcome, units: Mapping[str, str] | None = None) -> str:
    """Return a report as a page.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.
    units : mapping of str to str, optional
        Units of the variables and of t.

    Returns
    -------
    str

    Raises
    ------
    ImportError
        If jinja2 or matplotlib is missing.
    ValueError
        If a unit is given for something that is no variable.
    """
    try:
        import jinja2
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise ImportError(
            'LoopReport.to_html() needs jinja2 and matplotlib: pip install "pysindy-evolve[report]"'
        ) from error
    check_units("to_html", units, outcome.before.model.names)
    outcome = as_printed(outcome)
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    source = (files(__package__) / "report.html.j2").read_text(encoding="utf-8")
    head, rows = table_cells(outcome)
    return environment.from_string(source).render(
        outcome=outcome,
        verdict=verdict_of(outcome).partition(": "),
        before=equations_mathml(outcome.before.model),
        after=equations_mathml(outcome.after.model),
        parameters=[_listed(free_parameters(each)) for each in (outcome.before, outcome.after)],
        notes=note_on_shared_terms(outcome),
        head=head,
        rows=rows,
        effects=[_effect(effect, outcome.equations.inner_symbols) for effect in outcome.effects],
        p_explained=p_of_effects(outcome),
        experiments=paragraphs(plan(outcome, units), units),
        remains=[line.replace(" %", "\u00a0%") for line in remains(outcome)],
        last_look=_rejected_picture(outcome),
        pictures=_pictures(outcome, units),
        facts=_facts(outcome, units),
    )


def _listed(text: str) -> tuple[str, list[str]]:
    """Return the title of a list and its items, so that lines break between these only."""
    title, _, items = text.partition(": ")
    return title, items.split(", ")


def _effect(effect: Effect, symbols: Sequence[Any]) -> dict[str, Any]:
    own = () if effect.quantities else range(len(effect.expressions))
    products = [line for k in own for line in in_equation(effect, k, symbols)]
    return {
        "name": effect.name,
        "place": effect.place,
        "entry": effect.entry,
        "coefficients": _coefficients(effect, symbols),
        "meaning": _as_sentences(meant(effect, symbols)),
        "numbers": _as_sentences([*products, *numbers_inside(effect, symbols), *pumped(effect)]),
        "share": f"{100 * effect.explained:.0f}",
        "of_what": whose_share(effect),
        "p": f"{effect.p_value:.2g}",
        "n_twins": len(effect.twin_scores),
        "twins": _twins(effect.name, effect.twin_scores, effect.score, effect.is_limit),
        "alone": _as_sentences(["; ".join([without_rivals(effect), *named_together(effect)])]),
        "vague": _as_sentences(hardly_named(effect)),
        "rivals": [_rival(rival, effect) for rival in effect.rivals],
    }  # what the template report.html.j2 reads of an effect


def _as_sentences(lines: Sequence[str]) -> list[str]:
    """Return lines with a capital and a full stop; a line about a variable begins with its name."""
    begins = [
        line if line.split()[0].endswith(":") else line[0].upper() + line[1:] for line in lines
    ]
    return [f"{line}." for line in begins]


def _rival(rival: Alternative, effect: Effect) -> tuple[str, str, str, str]:
    """Return name, term, equation and p-value of an alternative, as `alternative` in effect_text.

    The equation is empty if it is that of the effect, the p-value if it was not tested.
    """
    where = "" if rival.state == effect.state else rival.state
    name = name_of_alternative(rival, effect, "the same in another form")
    p_text = "" if rival.name == effect.name else f"{rival.p_value:.2g}"
    return name, expression_mathml(rival.force), where, p_text


def _coefficients(effect: Effect, symbols: Sequence[Any]) -> list[tuple[str, ...]]:
    """Return for each coefficient its term or meaning, its value, and its interval."""
    if effect.quantities:
        term = expression_mathml(effect.term)
        numbers = zip(effect.coefficients, *effect.confidence_intervals.T, strict=True)
        shown = [f"{term}, {quantity}" for quantity in effect.quantities]
        return [(what, *_figures(*n)) for what, n in zip(shown, numbers, strict=True)]
    signed = (with_sign(effect, k, symbols) for k in range(len(effect.expressions)))
    return [(expression_mathml(term), *_figures(*numbers)) for term, *numbers in signed]


def _figures(value: float, low: float, high: float) -> tuple[str, str]:
    """Return a value and its interval as the printed report has them; none of an exact number."""
    return value_within(value, low, high), ends(low, high) if low < high else ""


def _shown(outcome: Outcome) -> list[int]:
    """Return the equations to draw: those with effects, or the one with the largest error."""
    states = outcome.before.model.states
    in_equations = (effect for effect in outcome.effects if not effect.of_sensor)
    with_effects = dict.fromkeys(states.index(effect.state) for effect in in_equations)
    return list(with_effects) or [int(np.argmax(outcome.before.derivative_error))]


def _pictures(outcome: Outcome, units: Mapping[str, str] | None) -> list[tuple[str, str]]:
    """Return the residual of each equation that matters, with the name of its state."""
    from .plot import draw_residuals

    pictures = []
    for index in _shown(outcome):
        state = outcome.before.model.states[index]
        draw = partial(draw_residuals, outcome=outcome, index=index, units=units)
        pictures.append((state, _svg((11.0, 8.5), f"residual {state}", draw)))
    return pictures


def _rejected_picture(outcome: Outcome) -> str:
    """Return the picture of the best candidate that did not pass, or nothing."""
    best = outcome.rejected
    if best is None or not len(best.twin_scores):
        return ""
    return _twins("last look", best.twin_scores, best.score)


def _twins(name: str, scores: np.ndarray, observed: float, is_limit: bool = False) -> str:
    """Return the histogram of the scores of twins, with that of the record as a line."""
    from .plot import draw_scores

    axis_label = (
        "samples in a row at the limit" if is_limit else "score: log(error without it / with it)"
    )

    def draw(figure: Any) -> None:
        draw_scores(figure.subplots(), scores, observed, axis_label)

    return _svg((4.6, 2.1), f"twins {name}", draw)


def _svg(size_: tuple[float, float], name: str, draw: Callable[[Any], None]) -> str:
    """Return a figure as SVG to embed in a page; the salt keeps its element ids unique there."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    from .plot import STYLE

    with rc_context({**STYLE, "svg.hashsalt": name, "svg.fonttype": "path"}):
        figure = Figure(figsize=size_, layout="constrained")
        FigureCanvasSVG(figure)
        draw(figure)
        out = StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None}, dpi=110, facecolor="none")
    page = out.getvalue()
    return page[page.index("<svg") :]


def _version() -> str:
    try:
        return version("pysindy-evolve")
    except PackageNotFoundError:
        return "not installed, run from its source"


def _facts(outcome: Outcome, units: Mapping[str, str] | None) -> list[tuple[str, str]]:
    """Return names and values of what the result depends on: version, records, settings."""
    unit = (units or {}).get("t", "")
    facts = [("pysindy_evolve", _version())]
    for name, records in (("training", outcome.train), ("held-out", outcome.test)):
        spans = [
            f"{r.n_samples} samples over {with_unit(r.t[-1] - r.t[0], 't', units)}" for r in records
        ]
        facts.append((f"{name} records", "; ".join(spans)))
    cutoff = outcome.train[0].cutoff
    if cutoff is not None:
        facts.append(
            ("cutoff of the preparation", f"{cutoff:.4g} cycles per {unit or 'unit of t'}")
        )
    rules = outcome.rules
    return [
        *facts,
        ("significance", f"{rules.significance:g}"),
        ("n_twins", f"{rules.n_twins}"),
        ("min_share", f"{rules.min_share:g}"),
        ("max_effects", f"{rules.max_effects}"),
        ("refine", rules.refine),
    ]
