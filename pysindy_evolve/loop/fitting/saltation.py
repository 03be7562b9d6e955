r"""Saltation matrices: how a switch changes a small deviation from a run.

Where a run crosses g = 0, and the equations contain sgn(g), a deviating run crosses a little sooner
or later. Meanwhile the two runs move at the rates of different sides. To first order this
multiplies the deviation by

.. math:: S = I + (f^+ - f^-) \, n^T / (n^T f^- + \partial g / \partial t), \quad n = \nabla g.

Where the run slides along g = 0, as a sticking body does, the deviation across the surface
vanishes.

References
----------
Leine, Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), chapter 7.
"""

from __future__ import annotations

import numpy as np

from ...equations import Equations
from ...simulation.structure import find_switches
from ...terms import Sum

# Finite difference, relative to the size of a state or of g; far above rounding.
RELATIVE_STEP = 1e-6
MAX_ENTRY = 10.0  # entry of a matrix; beyond, a run only grazes g = 0, and is not linearized


def saltation(
    equations: Equations, z: np.ndarray, scale: np.ndarray, dt: float
) -> np.ndarray | None:
    """Return the matrix that multiplies a deviation at the end of each step of some runs.

    Parameters
    ----------
    equations : Equations
        The model that made the runs.
    z : ndarray of shape (n_runs, n, n_variables)
        States, inputs and time along the runs.
    scale : ndarray of shape (n_states,)
        Size of each state.
    dt : float
        Length of a step.

    Returns
    -------
    ndarray of shape (n_runs, n - 1, n_states, n_states) or None
        None where the equations have no switch.
    """
    used = [t for t, c in zip(equations.terms, equations.coef.T, strict=True) if np.any(c)]
    switches = find_switches(tuple(used), len(equations.states))
    if not switches:
        return None
    n_runs, n, _ = z.shape
    n_states = len(equations.states)
    matrices = np.broadcast_to(np.eye(n_states), (n_runs, n - 1, n_states, n_states)).copy()
    for switch in switches:
        g = switch.g.evaluate(z.reshape(n_runs * n, -1)).reshape(n_runs, n)
        before, after = np.sign(g[:, :-1]), np.sign(g[:, 1:])
        run, row = np.nonzero(np.where(before != 0.0, after != before, after == 0.0))
        if len(run):
            surface = _Surface(equations, switch.g, scale, z[run, row], z[run, row + 1], dt)
            matrices[run, row] = (
                surface.matrices(before[run, row], after[run, row]) @ matrices[run, row]
            )
    return matrices


class _Surface:
    """Points at which steps from z0 to z1 meet g = 0, one in each row."""

    def __init__(
        self,
        equations: Equations,
        g: Sum,
        scale: np.ndarray,
        z0: np.ndarray,
        z1: np.ndarray,
        dt: float,
    ) -> None:
        self.equations, self.n_states = equations, len(scale)
        g0, g1 = g.evaluate(z0), g.evaluate(z1)
        share = np.where(g0 == g1, 1.0, g0 / np.where(g0 == g1, 1.0, g0 - g1))
        self.z = z0 + share[:, None] * (z1 - z0)
        steps = RELATIVE_STEP * scale
        moves = steps[:, None] * np.eye(len(scale), z0.shape[1])
        ahead, behind = ([g.evaluate(self.z + s * move) for move in moves] for s in (1.0, -1.0))
        self.normal = (np.column_stack(ahead) - np.column_stack(behind)) / (2.0 * steps)
        x = self.z[:, : len(scale)]
        first, last = (g.evaluate(np.column_stack([x, z[:, len(scale) :]])) for z in (z0, z1))
        self.own_rate = (last - first) / dt  # rate of g by inputs and time alone
        self.reach = RELATIVE_STEP * np.sqrt(np.sum((self.normal * scale) ** 2, axis=1))

    def matrices(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Return the matrix of each step, given the signs of g before and after it."""
        old = self.rates(np.where(before == 0.0, 1.0, before))
        other = self.rates(np.where(before == 0.0, -1.0, -before))
        across = self.across(old) + self.own_rate
        # A run that slides moves by a mixture of both sides that stays on the surface.
        share = _ratio(across, across - self.across(other) - self.own_rate)[:, None]
        new = np.where(after[:, None] == 0.0, old + share * (other - old), other)
        slides = (before == 0.0)[:, None]
        jump = np.where(slides, old - other, new - old)
        rate = np.where(slides[:, 0], -self.across(jump), across)
        gain = jump[:, :, None] * _ratio(self.normal, rate[:, None])[:, None, :]
        usable = np.all(np.abs(gain) <= MAX_ENTRY, axis=(1, 2))[:, None, None]
        return np.eye(self.n_states) + np.where(usable, gain, 0.0)

    def rates(self, side: np.ndarray) -> np.ndarray:
        """Return the right-hand sides just beside the surface, where g has the sign `side`."""
        size = np.sum(self.normal**2, axis=1)
        moved = self.z.copy()
        moved[:, : self.n_states] += self.normal * _ratio(side * self.reach, size)[:, None]
        n = self.n_states
        return self.equations.evaluate(moved[:, :n], moved[:, n:-1], moved[:, -1])

    def across(self, rates: np.ndarray) -> np.ndarray:
        """Return the rate of g by the motion of the states."""
        return np.sum(self.normal * rates, axis=1)


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Divide; zero where the divisor is zero."""
    return np.divide(a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape)), where=b != 0.0)
