"""Equations as functions in other languages."""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from typing import Any

import sympy
from sympy.codegen.rewriting import create_expand_pow_optimization
from sympy.core.function import AppliedUndef

from ..equations import Equations
from ..hidden_states.memory_equations import MemoryEquations
from .code_printers import CPrinter, JuliaPrinter, MatlabPrinter, ModelicaPrinter, PythonPrinter
from .symbolic import System, system_of


def to_code(model: Any, language: str = "python", name: str = "rhs") -> str:
    """Return a function in another language that computes the right-hand sides.

    Parameters
    ----------
    model : pysindy.SINDy, Equations or LoopReport
        Fitted model, or an object that holds one.
    language : {"python", "c", "matlab", "julia", "modelica"}
        Language of the code. Modelica gets the lines of an equation section.
    name : str
        Name of the function.

    Returns
    -------
    str
        The code, numbers in full precision. A user's functions without a sympy form are called by
        their name and must be written in that language by hand. For an input with a delay, pass
        its earlier value, as a comment at the top then says; Modelica delays it by itself.

    Raises
    ------
    ValueError
        If the language is unknown or cannot express a function, or `name` is no identifier.

    Examples
    --------
    >>> import numpy as np
    >>> from pysindy_evolve.equations import Equations
    >>> from pysindy_evolve.terms import only_term, variable
    >>> term = only_term(variable(0))
    >>> print(to_code(Equations((term,), np.array([[-2.5]]), ("q",)), "modelica"))
    der(q) = -2.5*q;
    """
    if not isinstance(language, str) or language.lower() not in LANGUAGES:
        raise ValueError(
            f"to_code(language=...) must be a known language; got {language!r}. "
            f"Choose from {', '.join(LANGUAGES)}."
        )
    plain = isinstance(name, str) and re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) is not None
    if not plain or name in _RESERVED:
        raise ValueError(
            f"to_code(name=...) must be an identifier; got {name!r}. "
            "Use letters, digits and underscores, and no word of one of the languages."
        )
    system, chosen = system_of(model, "to_code"), LANGUAGES[language.lower()]
    source = _source(system, language.lower(), name)
    code = chosen.write(source, name)
    notes = [] if language.lower() == "modelica" else _notes(source, system.equations)
    return "\n".join([*(f"{chosen.comment} {line}" for line in notes), code])


def _notes(source: _Source, equations: Equations) -> list[str]:
    """Return notes that a signature cannot express, one for each line."""
    pairs = zip(source.lefts, source.are_rates, strict=True)
    itself = [f"{name} is returned itself, not its rate" for name, is_rate in pairs if not is_rate]
    return [*itself, *_late_inputs(source.inputs, equations)]


def _late_inputs(names: Sequence[str], equations: Equations) -> list[str]:
    """Return a note for each input with a delay; `names` are those in the code."""
    pairs = zip(names, _delays(equations), strict=False)
    return [f"{u} acts late: give {u}(t - {delay:.6g})" for u, delay in pairs if delay]


def _delays(equations: Equations) -> tuple[float, ...]:
    return equations.delays if isinstance(equations, MemoryEquations) else ()


@dataclass(frozen=True)
class _Source:
    """The parts of the code in any language: safe names of variables, and right-hand sides."""

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    used: frozenset[str]
    lefts: tuple[str, ...]
    are_rates: tuple[bool, ...]
    sides: tuple[str, ...]
    modules: tuple[str, ...] = ()

    def local(self, line: Callable[[str, str, int], str]) -> list[str]:
        """Return a line for each variable that is used: line(name, array, index from 0)."""
        groups = (("state", self.states), ("input", self.inputs))
        return [
            line(name, array, index)
            for array, names in groups
            for index, name in enumerate(names)
            if name in self.used
        ]


# Names that mean something else in one of the languages, or in the functions written here.
_RESERVED_TEXT = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while end function global otherwise parfor persistent begin baremodule export let local
macro module quote using algorithm annotation block class connector der discrete each equation flow
input model output package parameter record then time type state rate t numpy pi e i j im sin cos
tan exp log sqrt abs fabs sign tanh sinh cosh asin acos atan pow max min y0 y1 yn j0 j1 jn gamma
main
"""
_RESERVED = frozenset(keyword.kwlist) | frozenset(_RESERVED_TEXT.split())


def _source(system: System, language: str, name: str) -> _Source:
    equations = system.equations
    safe = _safe_names((*equations.states, *equations.inputs), {name} | _RESERVED)
    time = "time" if language == "modelica" else "t"
    symbols = [sympy.Symbol(name, real=True) for name in (*safe, time)]
    if language == "modelica":
        for index, delay in enumerate(_delays(equations), start=len(equations.states)):
            late = f"delay({safe[index]}, {delay!r})"
            symbols[index] = sympy.Symbol(late, real=True) if delay else symbols[index]
    expressions = [side.to_sympy(symbols) for side in system.sides]
    of_user = {function.func.__name__ for e in expressions for function in e.atoms(AppliedUndef)}
    printer = LANGUAGES[language].printer({"user_functions": {name: name for name in of_user}})
    if language == "c":
        expand = create_expand_pow_optimization(4)  # q*q*q is many times faster than pow(q, 3)
        expressions = [expand(expression) for expression in expressions]
    try:
        sides = tuple(str(printer.doprint(expression)) for expression in expressions)
    except NotImplementedError as error:
        raise ValueError(
            f"to_code(language=...) must be able to express every function; got {language!r}, "
            f"which is not: {error}. Choose another language, or give the Operator no sympy form."
        ) from None
    n_states = len(equations.states)
    used = frozenset(str(symbols[index]) for index in system.used)
    modules = tuple(sorted({"numpy", *getattr(printer, "module_imports", ())}))
    states, inputs = tuple(safe[:n_states]), tuple(safe[n_states:])
    # A model whose targets are not the states has other names on the left, see `system_of`.
    lefts = states if len(states) == len(sides) else system.lefts
    return _Source(states, inputs, used, lefts, system.are_rates, sides, modules)


def _safe_names(names: Sequence[str], reserved: Set[str]) -> list[str]:
    """Return distinct identifiers that are valid in all languages."""
    taken: list[str] = []
    for name in names:
        safe = re.sub(r"\W", "_", _spelled(name), flags=re.ASCII).lstrip("_") or "variable"
        safe = f"x{safe}" if safe[0].isdigit() else safe
        while safe in reserved or safe in taken:
            safe += "_"
        taken.append(safe)
    return taken


def _spelled(name: str) -> str:
    """Return a name without accents; other alphabets are spelled out, such as theta."""
    plain = (c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    spelled = (c if c.isascii() else unicodedata.name(c, "_").split()[-1].lower() for c in plain)
    return "".join(spelled)


def _python(source: _Source, name: str) -> str:
    local = source.local(lambda name, array, i: f"    {name} = {array}[..., {i}]")
    sides = [f"    rate_{i} = {side}" for i, side in enumerate(source.sides)]
    rates = ", ".join(f"rate_{i}" for i in range(len(sides)))
    return "\n".join([
        *(f"import {module}" for module in source.modules), "", "",
        f"def {name}(t, state, input=None):",
        '    """Return the right-hand sides, one sample in each row."""',
        *_unpacked_python(source), *local, *sides,
        f"    rates = numpy.broadcast_arrays({rates}, state[..., 0])[:-1]",
        "    return numpy.stack(rates, axis=-1)",
    ])  # fmt: skip


def _unpacked_python(source: _Source) -> list[str]:
    """Return the lines that make arrays of the arguments; a wrong shape must not broadcast."""
    lines = ["    state = numpy.asarray(state, dtype=float)", *_checked("state", source.states)]
    if source.used & set(source.inputs):
        lines.append("    input = numpy.asarray(input, dtype=float)")
        if len(source.inputs) == 1:
            lines += [
                "    if input.shape == state.shape[:-1]:  # one number for each sample",
                "        input = input[..., None]",
            ]
        lines += _checked("input", source.inputs)
    return lines


def _checked(array: str, names: Sequence[str]) -> list[str]:
    return [
        f"    if {array}.shape[-1:] != ({len(names)},):",
        f'        raise ValueError("the last axis of {array} must hold {", ".join(names)}")',
    ]


def _c(source: _Source, name: str) -> str:
    local = source.local(lambda name, array, i: f"    const double {name} = {array}[{i}];")
    sides = [f"    rate[{i}] = {side};" for i, side in enumerate(source.sides)]
    arguments = "double t, const double *state, const double *input, double *rate"
    unused = ["    (void)t; (void)state; (void)input;"]
    lines = ["#include <math.h>", "", f"void {name}({arguments})", "{"]
    return "\n".join([*lines, *unused, *local, *sides, "}"])


def _matlab(source: _Source, name: str) -> str:
    local = source.local(lambda name, array, i: f"    {name} = {array}({i + 1});")
    sides = "; ...\n            ".join(source.sides)
    header = f"function rate = {name}(t, state, input)"
    return "\n".join([header, *local, f"    rate = [{sides}];", "end"])


def _julia(source: _Source, name: str) -> str:
    local = source.local(lambda name, array, i: f"    {name} = {array}[{i + 1}]")
    sides = [f"    rate[{i + 1}] = {side}" for i, side in enumerate(source.sides)]
    header = f"function {name}!(rate, state, input, t)"
    return "\n".join([header, *local, *sides, "    return nothing", "end"])


def _modelica(source: _Source, name: str) -> str:
    rows = zip(source.lefts, source.are_rates, source.sides, strict=True)
    return "\n".join(f"{f'der({q})' if is_rate else q} = {side};" for q, is_rate, side in rows)


@dataclass(frozen=True)
class _Language:
    printer: Callable[[dict[str, Any]], Any]
    write: Callable[[_Source, str], str]
    comment: str


LANGUAGES = {
    "python": _Language(PythonPrinter, _python, "#"),
    "c": _Language(CPrinter, _c, "//"),
    "matlab": _Language(MatlabPrinter, _matlab, "%"),
    "julia": _Language(JuliaPrinter, _julia, "#"),
    "modelica": _Language(ModelicaPrinter, _modelica, "//"),
}
