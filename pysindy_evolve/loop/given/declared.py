"""The declared model: text, sympy or a SINDy model, linear in its free parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pysindy as ps

from ...operators import Operator
from ...reading.names import check_known
from ...reading.text import RightHandSide, parse
from ...signals import Record
from ...terms import ONE, Sum, of_term
from .algebraic import motions_of
from .design import Column, Design
from .kinematics import disagreement
from .sindy_models import OWNER, design_of_sindy

CONTRADICTED = 0.1  # disagreement over the rate's spread; gains of two sensors differ by less


class DeclaredModel:
    r"""A model with known structure and free parameters that enter linearly.

    .. math:: \dot x_i = f_i(x, u, t) + \sum_p \theta_p \, g_{p,i}(x, u, t)

    Parameters
    ----------
    equations : mapping of str to str, sympy.Expr or float
        Right-hand side of each state, in the order of the columns of x. Names that are neither a
        state, an input, ``t`` nor in `known` are free parameters. A name that stands in several
        equations is one parameter.
    inputs : sequence of str
        Names of the inputs, in the order of the columns of u.
    known : mapping of str to float, optional
        Constants with a value.
    operators : sequence of Operator
        Functions of your own that the text may call.
    algebraic : bool
        Whether the right-hand sides are the targets themselves, such as a force F = c v + k x, and
        not their rates. Targets are the columns of x in the records, and stand where states do:
        ``{"F": "c*v + k*x"}``. What they depend on are inputs. `signals.as_target` makes such
        records, and says which inputs they have.

    Attributes
    ----------
    states, inputs : tuple of str
        Names of the states and inputs.
    parameters : tuple of str
        Names of the free parameters.
    known : dict of str to float
        Constants with a value.

    Raises
    ------
    ValueError
        If a text is not an expression of the whitelist, a free parameter enters nonlinearly, a
        name is used twice, or a known constant stands in no equation.
    TypeError
        If an argument is of the wrong type.

    Examples
    --------
    >>> declared = DeclaredModel({"q": "v", "v": "-k*q - c*v + F"}, inputs=["F"])
    >>> declared.parameters
    ('k', 'c')
    """

    def __init__(
        self,
        equations: Mapping[str, Any],
        inputs: Sequence[str] = (),
        known: Mapping[str, float] | None = None,
        operators: Sequence[Operator] = (),
        algebraic: bool = False,
    ) -> None:
        if not isinstance(equations, Mapping):
            raise TypeError(
                f"DeclaredModel(equations=...) must be a mapping of state to right-hand side; "
                f'got {type(equations).__name__}. Write {{"q": "v", "v": "-k*q"}}.'
            )
        if not equations:
            raise ValueError(
                "DeclaredModel(equations=...) must hold at least one state; got none. "
                'Write {"q": "v", "v": "-k*q"}.'
            )
        _check_kinds(inputs, known, operators)
        self.states = tuple(equations)
        self.inputs = (inputs,) if isinstance(inputs, str) else tuple(inputs)
        self.known = dict(known or {})
        _check_names((*self.states, *self.inputs, *self.known))
        check_known(self.known, "DeclaredModel")
        self.operators = tuple(operators)
        self.algebraic = bool(algebraic)
        variables = (*self.states, *self.inputs, "t")
        self.sides: tuple[RightHandSide, ...] = tuple(
            parse(
                text,
                variables,
                known=self.known,
                operators=self.operators,
                inputs=self.inputs,
                owner=f"DeclaredModel(equations[{state!r}]=...)",
            )
            for state, text in equations.items()
        )
        _check_used(self.known, self.sides)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the free parameters, in the order of the equations."""
        return tuple(dict.fromkeys(name for side in self.sides for name in side.parameters))

    def __repr__(self) -> str:
        named = zip(self.states, self.sides, strict=True)
        sides = ", ".join(f"{state}' = {self._text(side)}" for state, side in named)
        return f"DeclaredModel({sides})"

    def design(self) -> Design:
        """Return the known parts and the columns of the free parameters."""
        free = [dict(side.free) for side in self.sides]
        columns = tuple(
            Column(name, tuple(parts.get(name, Sum(())) for parts in free))
            for name in self.parameters
        )
        known = tuple(s.known for s in self.sides)
        return Design(self.states, self.inputs, known, columns, self.algebraic)

    def _text(self, side: RightHandSide) -> str:
        names = (*self.states, *self.inputs, "t")
        parts = [_times(name, part, names) for name, part in side.free]
        if side.known.parts or not parts:
            parts.append(side.known.name(names))
        return " + ".join(parts).replace("+ -", "- ")


def _times(name: str, part: Sum, names: Sequence[str]) -> str:
    """Return a parameter times what it multiplies, without brackets where it needs none."""
    if part == of_term(ONE):
        return name
    if len(part.parts) == 1 and part.parts[0][0] in (1.0, -1.0):
        sign = "-" if part.parts[0][0] < 0.0 else ""
        return f"{sign}{name}*{part.parts[0][1].name(names)}"
    return f"{name}*({part.name(names)})"


def design_of(declared: DeclaredModel | ps.SINDy, records: Sequence[Record]) -> Design:
    """Return the design of a declared model; a SINDy model that is not fitted is fitted first.

    Parameters
    ----------
    declared : DeclaredModel or pysindy.SINDy
        The terms of a SINDy model with a coefficient stay, and their coefficients are free.
    records : sequence of Record
        Training records.

    Returns
    -------
    Design

    Raises
    ------
    TypeError
        If `declared` is no model, or the library of a SINDy model is not one of ordinary terms.
    ValueError
        If an algebraic target depends on a target.
    """
    if isinstance(declared, DeclaredModel):
        design = declared.design()
        if not design.algebraic:
            return design
        _check_algebraic(design)
        return replace(design, motions=motions_of(records, len(design.states)))
    if not isinstance(declared, ps.SINDy):
        raise TypeError(
            f"{OWNER} must be a DeclaredModel or a pysindy.SINDy model; "
            f'got {type(declared).__name__}. Write DeclaredModel({{"q": "v", "v": "-k*q"}}).'
        )
    return design_of_sindy(declared, records)


def with_contradicted(design: Design, records: Sequence[Record]) -> Design:
    """Return a design that marks equations such as q' = v which the records contradict.

    Parameters
    ----------
    design : Design
        The declared model.
    records : sequence of Record
        Training records.

    Returns
    -------
    Design
    """
    pairs = ((state, design.derivative_of(state)) for state in range(len(design.states)))
    wrong = tuple(
        position
        for position, velocity in pairs
        if velocity is not None
        and design.kinematic(position)
        and disagreement(records, position, velocity) > CONTRADICTED
    )
    return replace(design, doubted=wrong)


def _check_algebraic(design: Design) -> None:
    targets = set(range(len(design.states)))
    for part in (*design.fixed, *(p for c in design.columns for p in c.parts)):
        if targets & part.variables:
            raise ValueError(
                f"{OWNER} must give algebraic targets from inputs and time alone; got one from "
                f"{', '.join(design.states)}. Write what it depends on as inputs."
            )


def _check_kinds(inputs: Any, known: Any, operators: Any) -> None:
    """Raise unless the optional arguments have the right types."""
    if not isinstance(inputs, Sequence):
        raise TypeError(
            f"DeclaredModel(inputs=...) must be a sequence of names; got {type(inputs).__name__}. "
            'Write inputs=["F"].'
        )
    if known is not None and not isinstance(known, Mapping):
        raise TypeError(
            f"DeclaredModel(known=...) must be a mapping of name to number; "
            f'got {type(known).__name__}. Write known={{"m": 0.5}}.'
        )
    if not isinstance(operators, Sequence) or not all(isinstance(o, Operator) for o in operators):
        raise TypeError(
            f"DeclaredModel(operators=...) must be a sequence of Operator objects; "
            f'got {operators!r}. Write operators=[Operator("name", function, arity)].'
        )


def _check_used(known: Iterable[str], sides: Sequence[RightHandSide]) -> None:
    """Raise if a constant stands in no equation; it may have another name there."""
    used = frozenset().union(*(side.names for side in sides))
    if unused := [name for name in known if name not in used]:
        raise ValueError(
            f"DeclaredModel(known=...) must hold constants of the equations; got {unused[0]!r}, "
            "which stands in none. Correct the name, or leave it out."
        )


def _check_names(names: Sequence[str]) -> None:
    for name in names:
        if not isinstance(name, str):
            raise TypeError(
                f"DeclaredModel(equations=...) must name states, inputs and constants by text; "
                f"got {type(name).__name__}. Quote the names."
            )
        if not name.isidentifier():
            raise ValueError(
                f"DeclaredModel(equations=...) must name states, inputs and constants by "
                f"identifiers; got {name!r}. Use letters, digits and underscores."
            )
        if names.count(name) > 1 or name == "t":
            raise ValueError(
                f"DeclaredModel(equations=...) must use each name once, and t for time only; "
                f"got {name!r} again. Rename the state, input or constant."
            )
