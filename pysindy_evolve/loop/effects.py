"""The vocabulary: effects that engineers know by name, as columns that may enter an equation.

Squares, products, absolute values and time have a mean, so each of them can pose as an offset. They
may enter only where the constant itself already stands (the marginality principle of regression,
Nelder 1977, DOI 10.2307/2344517).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy import fft

from ..operators import BUILTIN
from ..terms import ONE, Sum, add, call, constant, mul, power, sub, variable
from .algebraic import rounded, yields
from .design import Design

__all__ = ["VOCABULARY", "Candidate", "candidates", "periodic_candidates", "standing"]

VOCABULARY = (
    "Coulomb friction",
    "asymmetric Coulomb friction",
    "Stribeck friction",
    "position-dependent friction",
    "viscous damping",
    "quadratic drag",
    "nonlinear damping",
    "linear stiffness",
    "quadratic stiffness",
    "cubic stiffness",
    "quintic stiffness",
    "dead zone",
    "saturation",
    "gravity",
    "constant offset",
    "coupling",
    "input nonlinearity",
    "input gain",
    "drift",
    "periodic forcing",
    "position-periodic ripple",
    "input delay",
    "actuator lag",
    "hysteresis",
    "hidden state",
    "evolved term",
)

# Stribeck speeds and widths of dead zones and saturations, as shares of the size of the signal.
STRIBECK_SPEEDS = (0.03, 0.1, 0.3)
DEAD_ZONES = (0.08, 0.2, 0.5)
SATURATIONS = (0.2, 0.35, 0.5, 0.7, 0.9)
FINENESS = 8  # of the grid of frequencies: the true one lies close to it
LINE = 5.0  # prominence that makes a peak a line; noise reaches three to four


@dataclass(frozen=True)
class Shape:
    """A number that a term depends on other than linearly, and how to build the term from it."""

    build: Callable[[float], Sum]
    value: float


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing: its name, the equation it enters, its columns.

    `parents` are expressions that must already stand in the equation. An effect with a `shape`
    stands on a grid of its number, which is tuned once the effect is found.
    """

    name: str
    state: int
    terms: tuple[Sum, ...]
    parents: tuple[Sum, ...] = ()
    shape: Shape | None = field(default=None, compare=False)

    @property
    def is_exchange(self) -> bool:
        """Whether it changes what a term of the model depends on, instead of adding one."""
        return False

    @property
    def size(self) -> int:
        """Number of nodes of its terms."""
        return sum(term.size for term in self.terms)


def candidates(
    design: Design, scales: np.ndarray, signed: np.ndarray | None = None
) -> list[Candidate]:
    """Return the effects that may be missing from a design.

    Parameters
    ----------
    design : Design
        The model so far.
    scales : ndarray of shape (n_variables,)
        Largest magnitude of each variable: states, inputs, time.
    signed : ndarray of bool of shape (n_variables,), optional
        Which variables change their sign; by default all. The powers of one that does not pose
        as an offset no more than itself, and need none beside them.

    Returns
    -------
    list of Candidate
        Effects whose terms all stand in the equation already are left out.
    """
    present = standing(design)
    free = set() if signed is None else {int(v) for v in np.flatnonzero(~signed)}
    return [
        _freed(candidate, design, free)
        for state in design.open_states
        for candidate in _of_equation(design, state, scales)
        if not all((state, _bare(term)) in present for term in candidate.terms)
        # A dead zone lies about zero, and a position that never is there knows nothing of it.
        and not (candidate.name == "dead zone" and candidate.terms[0].variables & free)
    ]


def _freed(candidate: Candidate, design: Design, free: set[int]) -> Candidate:
    """Drop the offset from the parents of an effect of variables that keep their sign.

    Not so in the equation of a velocity: a position that is never zero is only measured from
    somewhere else.
    """
    variables = frozenset().union(*(term.variables for term in candidate.terms))
    positioned = design.position_of(candidate.state) is not None
    if positioned or not variables & free or candidate.name == "drift":
        return candidate
    kept = tuple(parent for parent in candidate.parents if parent != OFFSET)
    return replace(candidate, parents=kept)


def periodic_candidates(
    state: int,
    time: int,
    residual: np.ndarray,
    drivers: np.ndarray,
    dt: float,
    n_peaks: int = 2,
) -> list[Candidate]:
    """Return sines and cosines at the strongest frequencies of a residual.

    A line that an input has too is no forcing of its own, but a response to the input that the
    model gets wrong, and is left out.

    Parameters
    ----------
    state : int
        Equation that the residual belongs to.
    time : int
        Column of the variables that holds time.
    residual : ndarray of shape (n_samples,)
        On a uniform grid of step dt.
    drivers : ndarray of shape (n_samples, n_inputs)
        Inputs.
    dt : float
        Sampling time, units of t.
    n_peaks : int
        How many frequencies to propose.

    Returns
    -------
    list of Candidate
    """
    n_fine = FINENESS * fft.next_fast_len(len(residual), real=True)
    spectrum = _fine_spectrum(residual, n_fine)
    inputs = [_fine_spectrum(column, n_fine) for column in drivers.T]
    lowest = FINENESS * 8  # fewer than eight periods in the record look like slow disturbances
    found: list[Candidate] = []
    while len(spectrum) > lowest + 1 and len(found) < n_peaks:
        peak = lowest + int(np.argmax(spectrum[lowest:]))
        if _prominence(spectrum, peak) < LINE:
            break
        if all(_prominence(driver, peak) < LINE for driver in inputs):
            cycles = _vertex(spectrum, peak) / (n_fine * dt)
            phase = mul(constant(2 * np.pi * cycles), variable(time))
            terms = (call(BUILTIN["sin"], phase), call(BUILTIN["cos"], phase))
            found.append(Candidate("periodic forcing", state, terms))
        spectrum[max(peak - 2 * FINENESS, 0) : peak + 2 * FINENESS + 1] = 0.0
    return found


def _fine_spectrum(signal: np.ndarray, n_fine: int) -> np.ndarray:
    """Return the amplitude spectrum on a grid that is eight times finer than the record gives."""
    centered = (signal - signal.mean()) * np.hanning(len(signal))
    return np.asarray(np.abs(fft.rfft(centered, n_fine)))


def _vertex(spectrum: np.ndarray, peak: int) -> float:
    """Return the place of a peak between grid points, from the parabola through three of them."""
    if not 0 < peak < len(spectrum) - 1:
        return float(peak)
    left, top, right = np.log(np.maximum(spectrum[peak - 1 : peak + 2], 1e-300))
    bend = left - 2.0 * top + right
    return peak + (0.5 * float((left - right) / bend) if bend < 0.0 else 0.0)


def _prominence(spectrum: np.ndarray, peak: int) -> float:
    """Return how far a line stands out of its surroundings, as a ratio of amplitudes."""
    near = slice(max(peak - FINENESS // 2, 0), peak + FINENESS // 2 + 1)
    wide = spectrum[max(peak - 20 * FINENESS, 0) : peak + 20 * FINENESS + 1]
    return float(spectrum[near].max() / max(np.median(wide), 1e-300))


def standing(design: Design) -> set[tuple[int, Sum]]:
    """Return equation and expression, without its coefficient, of all that stands in a design."""
    found = set()
    for state in range(len(design.states)):
        for part in (design.fixed[state], *(c.parts[state] for c in design.columns)):
            if part.parts:
                found.add((state, _bare(part)))
            found |= {(state, Sum(((1.0, term),))) for _, term in part.parts}
    return found


def _bare(expression: Sum) -> Sum:
    """Return an expression with its last coefficient made one."""
    leading = expression.parts[-1][0]
    return Sum(tuple((c / leading, term) for c, term in expression.parts))


OFFSET = Sum(((1.0, ONE),))


def _abs(a: Sum) -> Sum:
    return call(BUILTIN["abs"], a)


def _sgn(a: Sum) -> Sum:
    return call(BUILTIN["sgn"], a)


def _clipped(a: Sum, limit: float) -> Sum:
    """Return a between -limit and limit, written with absolute values."""
    edge = constant(limit)
    return mul(constant(0.5), sub(_abs(add(a, edge)), _abs(sub(a, edge))))


def _beyond(a: Sum, limit: float) -> Sum:
    """Return how far a lies outside of -limit to limit."""
    return sub(a, _clipped(a, limit))


def _stribeck(v: Sum, speed: float) -> Sum:
    """Return the sign of v with a bell around zero: friction that falls with the speed."""
    bell = call(BUILTIN["exp"], mul(constant(-1.0 / speed**2), power(v, 2)))
    return mul(_sgn(v), bell)


def _of_equation(design: Design, state: int, scales: np.ndarray) -> Iterator[Candidate]:
    """Go through the vocabulary for one equation, simple effects before composed ones."""

    def effect(
        name: str, *terms: Sum, parents: tuple[Sum, ...] = (), shape: Shape | None = None
    ) -> Candidate:
        columns = terms if shape is None else (shape.build(shape.value),)
        return Candidate(name, state, columns, parents, shape)

    n_states, n_inputs = len(design.states), len(design.inputs)
    if design.algebraic:
        yield from _of_target(effect, design, scales)
        return
    v, position = variable(state), design.position_of(state)
    yield effect("constant offset", OFFSET)
    yield from _frictions(effect, v, float(scales[state]))
    if position is not None:
        yield from _springs(effect, variable(position), v, float(scales[position]))
    for other in range(n_states):
        if other not in (state, position):
            yield from _couplings(effect, design, state, other)
    for column in range(n_states, n_states + n_inputs):
        own = [v] if position is None else [v, variable(position)]
        yield from _inputs(effect, variable(column), own, float(scales[column]))
    yield effect("drift", variable(n_states + n_inputs), parents=(OFFSET,))


def _of_target(effect, design: Design, scales: np.ndarray) -> Iterator[Candidate]:  # type: ignore[no-untyped-def]
    """Go through the effects of a target that is a function of inputs."""
    yield effect("constant offset", OFFSET)
    first = len(design.states)
    velocities = {v for _, v in design.motions}
    moving: set[int] = set()
    for x, v in design.motions:
        if x in velocities:  # velocity and acceleration
            yield from yields(effect, Shape, v, x, scales)
            continue
        yield from _frictions(effect, variable(v), float(scales[v]))
        yield from _springs(effect, variable(x), variable(v), float(scales[x]))
        yield from rounded(effect, Shape, v, scales)
        yield from yields(effect, Shape, x, v, scales)
        moving |= {x, v}
    for column in range(first, first + len(design.inputs)):
        if column not in moving:
            own = [variable(other) for other in sorted(moving)]
            yield from _inputs(effect, variable(column), own, float(scales[column]))


def _frictions(effect, v: Sum, speed: float) -> Iterator[Candidate]:  # type: ignore[no-untyped-def]
    yield effect("viscous damping", v)
    yield effect("Coulomb friction", _sgn(v))
    yield effect("asymmetric Coulomb friction", _abs(v), parents=(OFFSET, _sgn(v)))
    for share in STRIBECK_SPEEDS:
        shape = Shape(partial(_stribeck, v), share * speed)
        yield effect("Stribeck friction", shape=shape, parents=(_sgn(v),))
    yield effect("quadratic drag", mul(v, _abs(v)))
    yield effect("nonlinear damping", power(v, 3))


def _springs(effect, q: Sum, v: Sum, reach: float) -> Iterator[Candidate]:  # type: ignore[no-untyped-def]
    yield effect("linear stiffness", q)
    yield effect("quadratic stiffness", power(q, 2), parents=(OFFSET,))
    yield effect("cubic stiffness", power(q, 3))
    yield effect("quintic stiffness", power(q, 5))
    for share in DEAD_ZONES:
        yield effect("dead zone", shape=Shape(partial(_beyond, q), share * reach))
    yield effect("gravity", call(BUILTIN["sin"], q))
    yield effect("gravity", call(BUILTIN["cos"], q), parents=(OFFSET,))
    yield effect("nonlinear damping", mul(power(q, 2), v))
    yield effect("position-dependent friction", mul(_abs(q), _sgn(v)))
    yield effect("position-dependent friction", mul(power(q, 2), _sgn(v)))
    yield effect("position-dependent friction", mul(q, _sgn(v)), parents=(_sgn(v),))
    yield effect("coupling", mul(q, v), parents=(OFFSET,))


def _couplings(effect, design: Design, state: int, other: int) -> Iterator[Candidate]:  # type: ignore[no-untyped-def]
    own, w = variable(state), variable(other)
    yield effect("coupling", w)
    yield effect("coupling", mul(own, w), parents=(OFFSET,))
    yield effect("coupling", power(w, 2), parents=(OFFSET,))
    velocity = design.position_of(state) is not None
    if velocity and design.position_of(other) is not None:
        yield effect("Coulomb friction", _sgn(sub(own, w)))
    position = design.position_of(state)
    if position is not None and design.derivative_of(other) is not None:
        stretch = sub(variable(position), w)
        yield effect("cubic stiffness", power(stretch, 3))


def _inputs(effect, u: Sum, own: list[Sum], reach: float) -> Iterator[Candidate]:  # type: ignore[no-untyped-def]
    yield effect("input gain", u)
    for x in own:
        yield effect("input gain", mul(u, x), parents=(OFFSET,))
    yield effect("input nonlinearity", power(u, 2), parents=(OFFSET,))
    yield effect("input nonlinearity", mul(u, _abs(u)))
    yield effect("input nonlinearity", power(u, 3))
    for share in SATURATIONS:
        yield effect("saturation", shape=Shape(partial(_clipped, u), share * reach))
