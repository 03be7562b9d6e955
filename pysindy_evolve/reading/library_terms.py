"""Reads a fitted PySINDy model into Equations.

The columns of each library are rebuilt as terms, from its attributes (powers, frequencies,
functions, inputs of each part) and never from the names that it prints. Every result
is compared with the library's own ``transform``, so a subclass that computes something else raises
an error instead of giving a wrong equation.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import pysindy as ps
from pysindy.feature_library.base import BaseFeatureLibrary
from sklearn.exceptions import NotFittedError
from sklearn.utils.validation import check_is_fitted

from .. import checks, terms
from ..equations import Equations
from ..operators import BUILTIN, Operator
from ..substitution import substituted
from ..terms import Sum, of_term
from .tracing import trace


def from_model(model: Any, owner: str = "from_model(model=...)") -> Equations:
    """Read a fitted model.

    Parameters
    ----------
    model : pysindy.SINDy, Equations, or an object with such `equations` or `model`
        The model.
    owner : str
        The call and parameter to name in an error.

    Returns
    -------
    Equations
        Term j is column j of the feature library; an intercept of the optimizer comes last.

    Raises
    ------
    TypeError
        If it is no model, or its library has no form as ordinary terms (PDE and weak libraries).
    sklearn.exceptions.NotFittedError
        If it has not been fitted.
    ValueError
        If it was fitted with more or fewer names than columns.
    """
    if isinstance(model, Equations):
        return model
    if isinstance(model, ps.SINDy):
        return _from_sindy(model, owner)
    if isinstance(model, ps.DiscreteSINDy):
        raise TypeError(
            f"{owner} must be a model of rates; got a DiscreteSINDy, whose equations give the next "
            "sample. Fit a ps.SINDy."
        )
    for attribute in ("equations", "model"):
        inner = getattr(model, attribute, None)
        if isinstance(inner, Equations | ps.SINDy):
            return from_model(inner, owner)
    raise TypeError(
        f"{owner} must be a fitted pysindy.SINDy or something that holds one; "
        f"got {type(model).__name__}. Fit a model first, and pass it as it is; of a DeclaredModel "
        "pass close_loop(declared, record).model, where max_effects=0 fits it and adds nothing."
    )


def columns_of(library: BaseFeatureLibrary, owner: str = "columns_of(library=...)") -> list[Sum]:
    """Return the columns of a fitted library as terms, in the order of its ``transform``.

    Parameters
    ----------
    library : pysindy feature library
        Polynomial, Fourier, Identity, Custom, Concat, Tensored, Generalized and Parameterized
        libraries, and libraries that hold their terms as `terms_`.
    owner : str
        The call and parameter to name in an error.

    Returns
    -------
    list of Sum

    Raises
    ------
    TypeError
        If a library is not one of ordinary terms, or does not compute what its class does.
    """
    columns = _Reader(owner).columns(library, range(library.n_features_in_))
    _check_against_transform(library, columns, owner)
    return columns


def check_ordinary(library: Any, owner: str) -> None:
    """Raise if the columns of a library, fitted or not, are not functions of one row.

    Parameters
    ----------
    library : pysindy feature library
        The library; its parts are checked too.
    owner : str
        The call and parameter to name in an error.

    Raises
    ------
    TypeError
        If it is, or holds, a PDE or a weak library.
    """
    if isinstance(library, _NOT_ORDINARY):
        raise _not_ordinary(library, owner)
    for part in getattr(library, "libraries", None) or ():
        check_ordinary(part, owner)


_NOT_ORDINARY = (ps.PDELibrary, ps.WeakPDELibrary)


def _not_ordinary(library: Any, owner: str) -> TypeError:
    return TypeError(
        f"{owner} must have a feature library of ordinary terms; got "
        f"{type(library).__name__}. Use PolynomialLibrary, FourierLibrary, CustomLibrary, "
        "their combinations, or EvolvingLibrary."
    )


def _from_sindy(model: ps.SINDy, owner: str) -> Equations:
    try:
        check_is_fitted(model)
    except NotFittedError:
        raise NotFittedError(
            f"{owner} must be fitted; got a {type(model).__name__} that is not. Call fit first."
        ) from None
    columns = columns_of(model.feature_library, owner)
    coef = np.atleast_2d(np.asarray(model.coefficients(), dtype=float))
    products = [terms.as_product(column) for column in columns]
    intercept = np.broadcast_to(getattr(model.optimizer, "intercept_", 0.0), len(coef))
    if np.any(intercept != 0.0):
        products.append(terms.ONE)
        coef = np.column_stack([coef, intercept])
    names = tuple(str(name) for name in model.feature_names)
    checks.feature_names(names, model.feature_library.n_features_in_)
    n_states = len(names) - model.n_control_features_
    return Equations(tuple(products), coef, names[:n_states], names[n_states:])


class _Reader:
    """Builds columns; gives functions that cannot be traced unique names."""

    def __init__(self, owner: str) -> None:
        self.owner = owner
        self.opaque: dict[str, Callable[..., Any]] = {}

    def columns(self, library: Any, inputs: Sequence[int]) -> list[Sum]:
        """Return the columns of a library that sees the given variables."""
        if hasattr(library, "terms_"):
            return self._with_terms(library, inputs)
        if isinstance(library, ps.PolynomialLibrary):
            return [_monomial(powers, inputs) for powers in library.powers_]
        if isinstance(library, ps.FourierLibrary):
            return _fourier(library, inputs)
        if isinstance(library, ps.CustomLibrary):
            return self._custom(library, inputs)
        if isinstance(library, ps.ConcatLibrary):
            return [c for part in library.libraries for c in self.columns(part, inputs)]
        if isinstance(library, ps.TensoredLibrary):
            return self._tensored(library, inputs)
        if isinstance(library, ps.GeneralizedLibrary):
            return self._generalized(library, inputs)
        raise _not_ordinary(library, self.owner)

    def _with_terms(self, library: Any, inputs: Sequence[int]) -> list[Sum]:
        base = getattr(library, "base_library_", None)
        fixed = [] if base is None else self.columns(base, inputs)
        grown = [t if isinstance(t, Sum) else of_term(t) for t in library.terms_]
        place = {i: terms.variable(column) for i, column in enumerate(inputs)}
        return fixed + [substituted(column, place) for column in grown]

    def _custom(self, library: ps.CustomLibrary, inputs: Sequence[int]) -> list[Sum]:
        result = [terms.constant(1.0)] if library.include_bias else []
        for function, namer in zip(library.functions, library.function_names, strict=True):
            arity = _arity(function)
            # The library's own rule for the variables that a function of several sees.
            groups = library._combinations(len(inputs), arity, library.interaction_only)
            operator = None
            for group in groups:
                chosen = [inputs[index] for index in group]
                column = trace(function, chosen)
                if column is None:
                    operator = operator or self._operator(function, namer, arity)
                    column = terms.call(operator, *map(terms.variable, chosen))
                result.append(column)
        return result

    def _operator(self, function: Callable[..., Any], namer: Any, arity: int) -> Operator:
        """Wrap a function as it is, under its printed name, with a number if that is taken."""
        found = re.match(r"([^\W\d]\w*)\(", str(namer(*["_"] * arity)))
        stem = name = found.group(1) if found else "f"
        number = 0
        while name in BUILTIN or self.opaque.get(name, function) is not function:
            number += 1
            name = f"{stem}_{number}"
        self.opaque[name] = function
        return Operator(name, function, arity)

    def _tensored(self, library: ps.TensoredLibrary, inputs: Sequence[int]) -> list[Sum]:
        result = [terms.constant(1.0)]
        for part, chosen in zip(library.libraries, library.inputs_per_library, strict=True):
            columns = self.columns(part, _chosen(inputs, chosen))
            result = [terms.mul(a, b) for a in result for b in columns]
        return result

    def _generalized(self, library: ps.GeneralizedLibrary, inputs: Sequence[int]) -> list[Sum]:
        result: list[Sum] = []
        for index, part in enumerate(library.libraries_full_):
            if index >= len(library.inputs_per_library):  # a tensor product, which sees all inputs
                result += self.columns(part, inputs)
            elif index not in library.exclude_libraries:
                chosen = library.inputs_per_library[index]
                result += self.columns(part, _chosen(inputs, chosen))
        return result


def _monomial(powers: Iterable[int], inputs: Sequence[int]) -> Sum:
    result = terms.constant(1.0)
    for index, exponent in zip(inputs, powers, strict=True):
        result = terms.mul(result, terms.power(terms.variable(index), int(exponent)))
    return result


def _fourier(library: ps.FourierLibrary, inputs: Sequence[int]) -> list[Sum]:
    names = ["sin"] * bool(library.include_sin) + ["cos"] * bool(library.include_cos)
    return [
        terms.call(BUILTIN[name], terms.mul(terms.constant(frequency), terms.variable(index)))
        for frequency in range(1, library.n_frequencies + 1)
        for index in inputs
        for name in names
    ]


def _arity(function: Any) -> int:
    return function.nin if isinstance(function, np.ufunc) else function.__code__.co_argcount


def _chosen(inputs: Sequence[int], chosen: Iterable[int]) -> list[int]:
    """Return the inputs of one part, each once, as PySINDy drops repeated ones."""
    return [inputs[index] for index in dict.fromkeys(chosen)]


def _check_against_transform(library: Any, columns: Sequence[Sum], owner: str) -> None:
    n_inputs = library.n_features_in_
    scale = np.array([0.0, 1e-3, 0.5, 1.0, 2.0])
    signs = np.random.default_rng(0).uniform(-1.5, 1.5, (len(scale), n_inputs))
    x = scale[:, None] * signs
    with np.errstate(all="ignore"):
        expected = np.asarray(library.transform(x), dtype=float)
        cache: terms.Cache = {}
        found = np.column_stack([column.evaluate(x, cache) for column in columns])
    same_shape = found.shape == expected.shape
    # Where the library has no value, as x * 1/x at zero, the simplified term may have one.
    found = np.where(np.isfinite(expected), found, expected) if same_shape else found
    if not (same_shape and np.allclose(found, expected, rtol=1e-8, atol=1e-10, equal_nan=True)):
        raise TypeError(
            f"{owner} must have a feature library that computes what its class does; got a "
            f"{type(library).__name__} whose transform gives other values. "
            "Put functions of your own into a CustomLibrary."
        )
