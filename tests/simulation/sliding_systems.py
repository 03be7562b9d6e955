"""Equations with dry friction that the tests of the simulation share."""

import numpy as np

from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import Sum, add, call, constant, mul, power, variable


def equations(rows, states, inputs=()):
    """Build Equations from one Sum for each state."""
    terms = tuple(dict.fromkeys(term for row in rows for _, term in row.parts))
    coef = np.zeros((len(rows), len(terms)))
    for i, row in enumerate(rows):
        for coefficient, term in row.parts:
            coef[i, terms.index(term)] = coefficient
    return Equations(terms, coef, tuple(states), tuple(inputs))


def total(*parts: tuple[float, Sum]) -> Sum:
    result = constant(0.0)
    for coefficient, term in parts:
        result = add(result, mul(constant(coefficient), term))
    return result


def sgn(argument: Sum) -> Sum:
    return call(BUILTIN["sgn"], argument)


q, v, third = variable(0), variable(1), variable(2)


def block(friction=2.0, stiffness=0.0, damping=0.0, inputs=("F",)):
    """q'' = -stiffness q - damping v - friction sgn(v) + F."""
    force = [(1.0, third)] if inputs else []
    row = total((-stiffness, q), (-damping, v), (-friction, sgn(v)), *force)
    return equations([v, row], ("q", "v"), inputs)


def duffing():
    """The friction rig of the paper, equation (7), coefficients of experiment 1."""
    friction = mul(power(q, 2), sgn(v))
    row = total(
        (-1.1, v), (-691.92, q), (-2.37e6, power(q, 3)), (-2.93, sgn(v)), (-7.63e3, friction),
        (-1.0, third),
    )  # fmt: skip
    return equations([v, row], ("q", "v"), ("zdd",))


def coulomb_oscillator(t, q0, omega, mu):
    """Exact free motion of q'' = -omega^2 q - mu sgn(v) from rest at q0 > 0."""
    out, start, begin = np.empty((len(t), 2)), q0, 0.0
    half, offset = np.pi / omega, mu / omega**2
    while abs(start) > offset:
        center = np.sign(start) * offset
        swing = (t >= begin) & (t < begin + half)
        phase = omega * (t[swing] - begin)
        out[swing, 0] = center + (start - center) * np.cos(phase)
        out[swing, 1] = -(start - center) * omega * np.sin(phase)
        start, begin = 2 * center - start, begin + half
    out[t >= begin] = (start, 0.0)
    return out
