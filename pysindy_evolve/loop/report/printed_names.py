"""Names as they are printed: "quadratic drag" of a velocity is a "quadratic term" of a population.

The loop names effects by what they are in a machine. Where no equation says x' = v, the state v may
be a current, a level, a concentration or a population, and a name that holds for all of them is
printed.
"""

from __future__ import annotations

from dataclasses import replace

from ..effects.names import (
    ASYMMETRIC_FRICTION,
    COULOMB_FRICTION,
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
        The same one if all names stay.
    """
    design = outcome.design
    velocity_of = {k: design.derivative_of(k) for k in range(len(design.states))}
    moving = {k for pair in velocity_of.items() if pair[1] is not None for k in pair}
    others = {name for k, name in enumerate(design.states) if k not in moving}
    if design.algebraic or not others:  # a force has the frictions of its velocities
        return outcome
    steps = [replace(step, name=_printed(step.name, step.state, others)) for step in outcome.steps]
    rejected = outcome.rejected and _rejected(outcome.rejected, others)
    effects = [_effect(effect, others) for effect in outcome.effects]
    return replace(outcome, effects=effects, steps=steps, rejected=rejected)


def _printed(name: str, state: str, others: set[str]) -> str:
    """Return a name as it is printed; `others` are the states that are no part of a motion."""
    return OF_ANY_STATE.get(name, name) if state in others else name


def _effect(effect: Effect, others: set[str]) -> Effect:
    rivals = [replace(one, name=_printed(one.name, one.state, others)) for one in effect.rivals]
    together = [_printed(name, effect.state, others) for name in effect.together]
    name = _printed(effect.name, effect.state, others)
    alternatives = [_printed(one, effect.state, others) for one in effect.alternatives]
    return replace(
        effect,
        name=name,
        rivals=tuple(rivals),
        together=tuple(together),
        alternatives=tuple(alternatives),
    )


def _rejected(rejected: Rejected, others: set[str]) -> Rejected:
    group = tuple(
        replace(one, name=_printed(one.name, rejected.variables[one.state], others))
        for one in rejected.tried.group
    )
    return replace(rejected, tried=replace(rejected.tried, group=group))
