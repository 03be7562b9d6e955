"""The table of basis functions: name, arity, numpy form, sympy form.

No operator is protected: ``div`` divides, ``log`` takes logarithms, ``sqrt`` takes roots. The
search rejects a term with a value that is not finite and never patches it, so that the same term is
scored, printed, simulated and exported.
"""

from __future__ import annotations

import keyword
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from . import checks


@dataclass(frozen=True)
class Operator:
    """A basis function of the search.

    Parameters
    ----------
    name : str
        Name under which the function is printed, a Python identifier.
    function : callable
        Maps `arity` arrays of shape (n_samples,) to one array of shape (n_samples,), element by
        element. Ufuncs are welcome.
    arity : int
        Number of arguments, at least 1.
    sympy : callable, optional
        The same function on sympy expressions. Without it the function is printed and exported
        under its name, as an undefined sympy function.

    Raises
    ------
    TypeError
        If `function` or `sympy` is not callable, or `name` not a string.
    ValueError
        If `name` is not an identifier, or `arity` below 1.

    Examples
    --------
    >>> import numpy as np
    >>> relu = Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    >>> relu(np.array([-1.0, 2.0]))
    array([0., 2.])
    """

    name: str
    function: Callable[..., Any]
    arity: int
    sympy: Callable[..., Any] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(
                f"Operator(name=...) must be a string; got {type(self.name).__name__}. "
                "Give the name to print."
            )
        if not self.name.isidentifier() or keyword.iskeyword(self.name):
            raise ValueError(
                f"Operator(name=...) must be an identifier; got {self.name!r}. "
                "Use letters, digits and underscores."
            )
        for field in ("function", "sympy"):
            value = getattr(self, field)
            if not callable(value) and not (field == "sympy" and value is None):
                raise TypeError(
                    f"Operator({field}=...) must be callable; got {type(value).__name__}. "
                    "Give a function of arrays, such as np.sign."
                )
        advice = "Give the number of arguments of the function."
        checks.count("Operator", "arity", self.arity, advice=advice)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle a built-in operator by its name, as its functions may be lambdas."""
        if BUILTIN.get(self.name) == self:
            return _builtin, (self.name,)
        return Operator, (self.name, self.function, self.arity, self.sympy)

    def __call__(self, *arguments: np.ndarray) -> np.ndarray:
        """Apply the numpy form; numpy's floating-point warnings are silenced by the caller."""
        return self.function(*arguments)

    def to_sympy(self, *arguments: Any) -> Any:
        """Apply the sympy form, or an undefined function of the same name."""
        if self.sympy is not None:
            return self.sympy(*arguments)
        return sympy.Function(self.name, real=True)(*arguments)


def _softsign(a: Any) -> Any:
    """Return a/(1 + |a|) with the factor of a moved into the denominator: x/(c + |x|)."""
    factor, rest = sympy.sympify(a).as_coeff_Mul()
    return sympy.sign(factor) * rest / (1 / sympy.Abs(factor) + sympy.Abs(rest)) if factor else a


def _table(*operators: Operator) -> dict[str, Operator]:
    return {operator.name: operator for operator in operators}


# Arithmetic (the first seven) is absorbed by the canonical form of terms, see terms/.
BUILTIN: dict[str, Operator] = _table(
    Operator("add", np.add, 2, sympy.Add),
    Operator("sub", np.subtract, 2, lambda a, b: a - b),
    Operator("mul", np.multiply, 2, sympy.Mul),
    Operator("div", np.divide, 2, lambda a, b: a / b),
    Operator("neg", np.negative, 1, lambda a: -a),
    Operator("square", np.square, 1, lambda a: a**2),
    Operator("cube", lambda a: a * a * a, 1, lambda a: a**3),
    Operator("sin", np.sin, 1, sympy.sin),
    Operator("cos", np.cos, 1, sympy.cos),
    Operator("tan", np.tan, 1, sympy.tan),
    Operator("exp", np.exp, 1, sympy.exp),
    Operator("log", np.log, 1, sympy.log),
    Operator("sqrt", np.sqrt, 1, sympy.sqrt),
    Operator("abs", np.abs, 1, sympy.Abs),
    Operator("sgn", np.sign, 1, sympy.sign),
    Operator("tanh", np.tanh, 1, sympy.tanh),
    Operator("sinh", np.sinh, 1, sympy.sinh),
    Operator("cosh", np.cosh, 1, sympy.cosh),
    Operator("asin", np.arcsin, 1, sympy.asin),
    Operator("acos", np.arccos, 1, sympy.acos),
    Operator("atan", np.arctan, 1, sympy.atan),
    Operator("softsign", lambda a: a / (1.0 + np.abs(a)), 1, _softsign),
)

# Curved functions. A search never grows one inside another.
CURVED = (
    *("sin", "cos", "tan", "asin", "acos", "atan", "exp", "log"),
    *("sinh", "cosh", "tanh", "softsign"),
)
# Those with a factor to tune in their argument; in a logarithm, a factor is only an offset.
SCALED = tuple(name for name in CURVED if name != "log")


def _builtin(name: str) -> Operator:
    return BUILTIN[name]


def resolve(operators: Iterable[str | Operator], owner: str = "resolve") -> tuple[Operator, ...]:
    """Look up operators by name; a user's own are only tested on arrays.

    Parameters
    ----------
    operators : iterable of str or Operator
        Names of built-in operators, or `Operator` objects.
    owner : str
        The call to name in an error.

    Returns
    -------
    tuple of Operator

    Raises
    ------
    ValueError
        If a name is unknown, given twice, or an operator fails on arrays.
    TypeError
        If an entry is neither a name nor an `Operator`.
    """
    if isinstance(operators, str | Operator):
        operators = (operators,)
    resolved = tuple(_lookup(entry, owner) for entry in operators)
    names = [operator.name for operator in resolved]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(
                f"{owner}(operators=...) must name each operator once; got {name!r} twice. "
                "Rename or drop one of them."
            )
    if not resolved:
        raise ValueError(
            f"{owner}(operators=...) must not be empty; got (). "
            'Give at least one operator, such as "mul".'
        )
    for operator in resolved:
        if BUILTIN.get(operator.name) != operator:
            _check_on_arrays(operator, owner)
    return resolved


def _lookup(entry: str | Operator, owner: str) -> Operator:
    if isinstance(entry, Operator):
        return entry
    if not isinstance(entry, str):
        raise TypeError(
            f"{owner}(operators=...) must hold names or Operator objects; "
            f"got {type(entry).__name__}. Wrap a function: Operator('name', function, arity)."
        )
    if entry not in BUILTIN:
        raise ValueError(
            f"{owner}(operators=...) must name built-in operators; got {entry!r}. "
            f"Choose from {', '.join(BUILTIN)}, or pass an Operator of your own."
        )
    return BUILTIN[entry]


# Of both signs and without zero, so that a function with poles or for one sign only also passes.
_PROBE = np.array([-1.5, -0.5, 0.25, 0.75, 2.0])


def _one_by_one(operator: Operator, arguments: Sequence[np.ndarray]) -> np.ndarray:
    """Evaluate a function element by element; np.vectorize may round all but the first."""
    rows = (operator(*(np.array([value]) for value in row)) for row in zip(*arguments, strict=True))
    return np.array([float(np.asarray(row).item()) for row in rows])


def _check_on_arrays(operator: Operator, owner: str) -> None:
    arguments: Sequence[np.ndarray] = [_PROBE + 0.1 * i for i in range(operator.arity)]
    problem = None
    try:
        with np.errstate(all="ignore"):
            result = np.asarray(operator(*arguments))
        if result.shape != _PROBE.shape:
            problem = f"an array of shape {result.shape} for inputs of shape {_PROBE.shape}"
        elif not (np.issubdtype(result.dtype, np.number) or result.dtype == bool):
            problem = f"an array of type {result.dtype}"
        elif np.iscomplexobj(result):
            problem = "complex numbers"
        elif not np.allclose(result, _one_by_one(operator, arguments), equal_nan=True):
            problem = "other values for an array than for its elements"
    # A scalar function raises these when it is given arrays; other errors go to its author.
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        problem = f"{type(error).__name__}: {error}"
    if problem is not None:
        raise ValueError(
            f"{owner}(operators=...) must work element by element on arrays; "
            f"{operator.name!r} gave {problem}. "
            "Write it with numpy functions, or wrap it in np.vectorize(function, otypes=[float])."
        )
