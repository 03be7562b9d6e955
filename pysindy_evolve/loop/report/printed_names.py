"""Names as they are printed: "quadratic drag" of a velocity is a "quadratic term" of a population.

The loop names effects by what they are in a machine. Where no equation says x' = v and the state v
keeps its sign, it may be a level, a temperature, a concentration or a population, and a name that
holds for all of them is printed. The speed of a motor turns, and keeps its friction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...signals import Record
from ...terms import Sum
from ..effects.names import (
    ASYMMETRIC_FRICTION,
    COULOMB_FRICTION,
    DEAD_ZONE,
    FORCING,
    NONLINEAR_DAMPING,
    QUADRATIC_DRAG,
    STRIBECK_FRICTION,
    VISCOUS_DAMPING,
)
from ..evidence.rejected import Rejected
from ..facts.effect import Effect
from ..facts.outcome import Outcome

OF_ANY_STATE = {
    COULOMB_FRICTION: "sign term",
    ASYMMETRIC_FRICTION: "asymmetric sign term",
    STRIBECK_FRICTION: "fading sign term",
    VISCOUS_DAMPING: "linear term",
    QUADRATIC_DRAG: "quadratic term",
    NONLINEAR_DAMPING: "nonlinear term",
}
PARAMETRIC = "parametric excitation"  # a forcing by which a coefficient varies periodically
THRESHOLD = "threshold"  # what a dead zone is of a level or a concentration
OF_VELOCITY = {printed: name for name, printed in OF_ANY_STATE.items()}


def as_printed(outcome: Outcome) -> Outcome:
    """Return an outcome whose effects have the names that are printed.

    Parameters
    ----------
    outcome : Outcome
        What the loop found.

    Returns
    -------
    Outcome
        With other names; all else is as it was.
    """
    design = outcome.design
    velocity_of = {k: design.derivative_of(k) for k in range(len(design.states))}
    moving = {k for pair in velocity_of.items() if pair[1] is not None for k in pair}
    others = {
        name
        for k, name in enumerate(design.states)
        if k not in moving and _keeps_sign(outcome.train, k)
    }
    if design.algebraic:  # a force has the frictions of its velocities
        others = set()
    names = _Names(frozenset(others), len(design.states), design.time)
    terms = {(effect.name, effect.state): effect.expressions for effect in outcome.effects}
    steps = [
        replace(step, name=names.of(step.name, step.state, terms.get((step.name, step.state), ())))
        for step in outcome.steps
    ]
    rejected = outcome.rejected and _rejected(outcome.rejected, names)
    effects = [_effect(effect, names) for effect in outcome.effects]
    return replace(outcome, effects=effects, steps=steps, rejected=rejected)


def _keeps_sign(records: Sequence[Record], state: int) -> bool:
    """Tell whether a state has one sign in all rows of records."""
    signs = np.concatenate([np.sign(record.x[:, state]) for record in records])
    return bool(abs(signs.sum()) == len(signs))


@dataclass(frozen=True)
class _Names:
    """Gives names as they are printed.

    Attributes
    ----------
    others : frozenset of str
        The states that are no part of a motion and keep their sign.
    n_states : int
        Number of declared states, the first variables.
    time : int
        Number of the time among the variables.
    """

    others: frozenset[str]
    n_states: int
    time: int

    def of(self, name: str, state: str, terms: Sequence[Sum]) -> str:
        """Return the printed name of an effect with these terms."""
        if name == FORCING and any(term.variables - {self.time} for term in terms):
            return PARAMETRIC
        if state not in self.others:
            return name
        has_input = any(max(term.variables, default=0) >= self.n_states for term in terms)
        if name == DEAD_ZONE and not has_input:
            return THRESHOLD
        return OF_ANY_STATE.get(name, name)


def _effect(effect: Effect, names: _Names) -> Effect:
    rivals = [
        replace(one, name=names.of(one.name, one.state, one.expressions)) for one in effect.rivals
    ]
    together = [names.of(name, effect.state, ()) for name in effect.together]
    name = names.of(effect.name, effect.state, effect.expressions)
    return replace(effect, name=name, rivals=tuple(rivals), together=tuple(together))


def _rejected(rejected: Rejected, names: _Names) -> Rejected:
    group = tuple(
        replace(one, name=names.of(one.name, rejected.variables[one.state], one.terms))
        for one in rejected.tried.group
    )
    return replace(rejected, tried=replace(rejected.tried, group=group))
