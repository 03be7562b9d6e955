"""A mass that nobody measured: the operator on the rows, and its two hidden states."""

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import pysindy_evolve as pse
from pysindy_evolve.equations import Equations
from pysindy_evolve.export import format_equations
from pysindy_evolve.hidden_states.flexible_mode import flexible_mode, stretch_along
from pysindy_evolve.hidden_states.memory_equations import with_memories
from pysindy_evolve.hidden_states.path_states import hidden_along, kind_of, path_sentences
from pysindy_evolve.terms import variable

T = np.arange(0.0, 20.0, 0.005)
FREQUENCY, DAMPING = 6.0, 0.05


def swing(t):
    """Position and velocity."""
    return np.sin(t) + 0.6 * np.sin(2.3 * t + 1.0), np.cos(t) + 1.38 * np.cos(2.3 * t + 1.0)


def hidden(frequency, damping, start):
    """Position and velocity of the hidden mass, integrated."""

    def rate(t, h):
        x, v = swing(t)
        return [h[1], frequency**2 * (x - h[0]) + 2.0 * damping * frequency * (v - h[1])]

    return solve_ivp(rate, (0.0, T[-1]), start, t_eval=T, rtol=1e-9, atol=1e-11).y


def attached(sides):
    """Equations of q and v with a hidden mass behind q."""
    path = flexible_mode(variable(0), variable(1), variable(2), FREQUENCY, DAMPING)
    terms = tuple(sum_.parts[0][1] for sum_ in (path, variable(1), variable(0)))
    return Equations(terms, np.array(sides, dtype=float), ("q", "v"))


OSCILLATOR = attached([[0, 1, 0], [-30, -0.5, -20]])


@pytest.mark.parametrize(("frequency", "damping"), [(6.0, 0.05), (0.7, 0.3), (30.0, 0.01)])
def test_operator_solves_the_differential_equation(frequency, damping):
    (x, v), (h, rate) = swing(T), hidden(frequency, damping, [0.3, -0.2])
    start = (x[0] - 0.3, v[0] + 0.2)
    stretch, moving = stretch_along(v, T, frequency, damping, start)
    assert stretch == pytest.approx(x - h, abs=2e-3)
    assert moving == pytest.approx(v - rate, abs=2e-3 * frequency)


def test_record_after_another_one_begins_at_rest():
    _, v = swing(T)
    twice = stretch_along(np.tile(v, 2), np.tile(T, 2), FREQUENCY, DAMPING)[0]
    once = stretch_along(v, T, FREQUENCY, DAMPING)[0]
    assert twice == pytest.approx(np.tile(once, 2))


def test_mass_is_written_as_two_states_with_equations_of_their_own():
    full = with_memories(OSCILLATOR, ())
    assert full.states == ("q", "v", "q_mode", "v_mode")
    q, v, h, w = sympy.symbols("q v q_mode v_mode", real=True)
    _, force, rate, own = full.to_sympy()
    stiffness, damper = FREQUENCY**2, 2.0 * DAMPING * FREQUENCY
    assert rate == w
    assert sympy.simplify(own - stiffness * (q - h) - damper * (v - w)) == 0
    left = sympy.Poly(force + 30.0 * own / stiffness + 20.0 * q + 0.5 * v, q, v, h, w)
    assert max(map(abs, left.coeffs())) < 1e-12
    assert format_equations(full).splitlines()[2] == "q_mode' = v_mode"


def test_simulated_mass_agrees_with_the_operator():
    full = with_memories(OSCILLATOR, ())
    run = pse.simulate(full, [1.0, 0.0], T, tolerance=1e-9)
    assert run[0].tolist() == [1.0, 0.0, 1.0, 0.0]  # it goes along
    assert full.along(run[:, :2], None, T) == pytest.approx(run[:, 2:], abs=5e-3)
    along = full.evaluate(run[:, :2], None, T)
    assert along == pytest.approx(full.evaluate(run, None, T)[:, :2], abs=0.2)


def test_states_of_several_paths_begin_each_with_their_own_values():
    (x, v), t = swing(T), T
    rows = np.column_stack([x, v, t])
    slow, fast = (
        flexible_mode(variable(0), variable(1), variable(2), f, DAMPING).parts[0][1].factors[0][0]
        for f in (2.0, 9.0)
    )
    both = hidden_along((slow, fast), rows, [0.1, 0.2, 0.3, 0.4])
    assert both[0] == pytest.approx([0.1, 0.2, 0.3, 0.4])
    assert both[:, 2:] == pytest.approx(kind_of(fast).along(fast, rows, [0.3, 0.4]))


def test_numbers_come_back_from_weights_and_are_said_in_words():
    (path,) = with_memories(OSCILLATOR, ()).paths
    kind = kind_of(path)
    assert kind.numbers_from(np.array(kind.weights(path))) == pytest.approx((FREQUENCY, DAMPING))
    expression = flexible_mode(variable(0), variable(1), variable(2), FREQUENCY, DAMPING)
    (said,) = path_sentences([expression], ("q", "v", "t"))
    assert said == "q_mode: swings at 6 radians per unit of t, damping ratio 0.05"
