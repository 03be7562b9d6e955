"""Friction that differs with the direction is an offset and a friction: one force in two names.

-a for v > 0 and b for v < 0 is -(a + b)/2 sgn(v) - (a - b)/2. No record can tell the two, so where
both parts were found the one name is an alternative to the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...terms import Sum, add, constant, mul, power
from ..effects.candidate import Candidate
from ..evidence.findings import Finding
from ..evidence.rivals import Rival

__all__ = ["with_asymmetry"]

ONE_WAY = "asymmetric Coulomb friction"


def with_asymmetry(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings in which friction beside an offset may be friction of unequal directions.

    Parameters
    ----------
    findings : sequence of Finding
        What was found.

    Returns
    -------
    list of Finding
    """
    rubbing = {f.candidate.state: f for f in findings if f.candidate.name == "Coulomb friction"}
    shifted = {f.candidate.state: f for f in findings if f.candidate.name == "constant offset"}
    taken = {f.candidate.state for f in findings if f.candidate.name == ONE_WAY}
    both = (set(rubbing) & set(shifted)) - taken
    told = []
    for finding in findings:
        state = finding.candidate.state
        if state in both and finding in (rubbing[state], shifted[state]):
            one_way = Rival(_one_way(rubbing[state].candidate), 1.0)
            finding = replace(finding, rivals=(*finding.rivals, one_way), contested=True)
        told.append(finding)
    return told


def _one_way(friction: Candidate) -> Candidate:
    """Return the part of a friction that acts in one direction only: (sgn(v) + sgn(v)^2) / 2."""
    (sign,) = friction.terms
    return replace(friction, name=ONE_WAY, terms=(_half(add(sign, power(sign, 2))),), parents=())


def _half(expression: Sum) -> Sum:
    return mul(constant(0.5), expression)
