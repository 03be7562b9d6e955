"""Grown terms that are products with another state: couplings, as of speeds about two other axes.

So is what turns one axis with the speed of a rotor, an input, times that of another axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...terms import Variable
from ..effects.candidate import Candidate
from ..effects.names import COUPLING, EVOLVED
from ..evidence.findings import Finding
from ..given.design import Design

__all__ = ["with_couplings_named"]


def with_couplings_named(design: Design, findings: Sequence[Finding]) -> list[Finding]:
    """Return findings in which a grown product with another state in it is called a coupling.

    The vocabulary holds those of a state itself with another one; all of them would be many.

    Parameters
    ----------
    design : Design
        The model.
    findings : sequence of Finding
        What was found.

    Returns
    -------
    list of Finding
    """
    return [
        replace(f, candidate=replace(f.candidate, name=COUPLING))
        if f.candidate.name == EVOLVED and _is_product(design, f.candidate)
        else f
        for f in findings
    ]


def _is_product(design: Design, candidate: Candidate) -> bool:
    own = {candidate.state, design.position_of(candidate.state)}
    acting = candidate.variables
    parts = [part for term in candidate.terms for _, part in term.parts]
    atoms = [atom for part in parts for atom, _ in part.factors]
    is_one = len(parts) == 1 and all(isinstance(atom, Variable) for atom in atoms)
    others = acting & set(range(len(design.states))) - own
    return is_one and len(atoms) > 1 and bool(others) and design.time not in acting
