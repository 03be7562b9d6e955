"""One trial: a simulated record, a fit to it, and the error of the equation it finds."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import pysindy as ps

from ..datasets import DuffingRig
from ..equations import Equations
from ..export import format_equations
from ..library import EvolvingLibrary
from ..optimizer import ElasticNet
from ..reading.library_terms import from_model
from ..signals import fuse
from ..terms import Product
from .cases import Case


@dataclass(frozen=True)
class Trial:
    """The result of one search.

    Parameters
    ----------
    case : Case
        The record.
    equation : str
        Right-hand side of the acceleration.
    extra, missing : tuple of str
        Terms that the truth does not have, and terms of the truth that were not found, in all
        equations.
    coefficient_error : float
        Largest error of a coefficient of the acceleration, % of the true one.
    error : float
        Error of the identified acceleration on the clean validation motion, % of the standard
        deviation of the clean acceleration.
    measured_error : float
        The same on the measured validation part, against the measured acceleration with its noise.
    seconds : float
        Processor time of the fit.
    """

    case: Case
    equation: str
    extra: tuple[str, ...]
    missing: tuple[str, ...]
    coefficient_error: float
    error: float
    measured_error: float
    seconds: float

    @property
    def exact(self) -> bool:
        """Whether every equation has the true terms and no other."""
        return not self.extra and not self.missing

    def to_dict(self) -> dict[str, Any]:
        """Return numbers and texts only, as JSON holds them."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Trial:
        """Return the trial that `to_dict` has converted."""
        lists = {name: tuple(values[name]) for name in ("extra", "missing")}
        return cls(**{**values, **lists, "case": Case(**values["case"])})


def run(case: Case) -> Trial:
    """Simulate a record, identify it, and compare the result with the truth."""
    rig = case.simulate()
    found, seconds = identify(case)
    extra, missing = _structure(rig.equations, found)
    return Trial(
        case,
        format_equations(found, digits=4).splitlines()[-1].split(" = ")[1],
        extra,
        missing,
        _coefficient_error(rig.equations, found),
        _error(found, np.column_stack([rig.q, rig.v]), rig.zdd[:, None], rig.a, rig),
        _error(found, rig.x, rig.u, rig.x_dot[:, 1], rig),
        seconds,
    )


@lru_cache
def identify(case: Case) -> tuple[Equations, float]:
    """Fit an ordinary `ps.SINDy` with an evolving library; return equations and processor time.

    Results are cached, so that a figure does not repeat a fit of this process.
    """
    rig = case.simulate()
    model = ps.SINDy(
        feature_library=EvolvingLibrary(random_state=case.seed, **case.setting.options),
        optimizer=ElasticNet(),
    )
    x, t, x_dot, u = (column[rig.train] for column in (rig.x, rig.t, rig.x_dot, rig.u))
    start = time.process_time()
    x_dot = fuse(t, x, x_dot) if case.fused else x_dot
    model.fit(x, t, x_dot=x_dot, u=u, feature_names=list(rig.names))
    return from_model(model), time.process_time() - start


def _terms(equations: Equations) -> list[dict[Product, float]]:
    """Return coefficient by term, for each equation."""
    return [
        {term: float(c) for term, c in zip(equations.terms, row, strict=True) if c}
        for row in equations.coef
    ]


def _structure(truth: Equations, found: Equations) -> tuple[tuple[str, ...], tuple[str, ...]]:
    pairs = list(zip(_terms(truth), _terms(found), strict=True))
    extra = (term for true, have in pairs for term in have.keys() - true.keys())
    missing = (term for true, have in pairs for term in true.keys() - have.keys())
    first, second = (sorted(term.name(truth.names) for term in side) for side in (extra, missing))
    return tuple(first), tuple(second)


def _coefficient_error(truth: Equations, found: Equations) -> float:
    true, have = _terms(truth)[-1], _terms(found)[-1]
    return 100.0 * max(abs(have.get(term, 0.0) - c) / abs(c) for term, c in true.items())


def _error(
    found: Equations, x: np.ndarray, u: np.ndarray, target: np.ndarray, rig: DuffingRig
) -> float:
    """Return the error on the validation part, %, without rows at rest (unknown friction)."""
    rows = np.arange(len(rig.t))[rig.validation]
    rows = rows[rig.v[rows] != 0.0]
    predicted = found.evaluate(x[rows], u[rows])[:, -1]
    return 100.0 * float(np.std(predicted - target[rows]) / np.std(target[rows]))


class Identified:
    """A record and the equations found in it, each computed when it is first used."""

    def __init__(self, case: Case) -> None:
        self.case = case

    @cached_property
    def rig(self) -> DuffingRig:
        """The record."""
        return self.case.simulate()

    @cached_property
    def equations(self) -> Equations:
        """The identified equations."""
        return identify(self.case)[0]

    @cached_property
    def predicted(self) -> np.ndarray:
        """Identified acceleration on the validation part, (n,)."""
        at = self.rig.validation
        return self.equations.evaluate(self.rig.x[at], self.rig.u[at])[:, -1]
