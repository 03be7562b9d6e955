"""A simulated linear axis with an encoder, whose declared model lacks dry friction or nothing.

M q'' = F - Fv v - Fc sgn(v), with q in m, v in m/s and the motor force F in N. A controller moves
the axis along a reference; only the position q (by an encoder) and F are measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from ..equations import Equations
from ..operators import BUILTIN
from ..simulation import simulate
from ..terms import as_product, call, sub, variable
from .measured import MeasuredRecord

MASS = 2.0  # kg
VISCOUS = 6.0  # N s/m
FRICTION = 3.0  # N
STROKE = 0.05  # m, largest reference
GAINS = (2_000.0, 80.0)  # N/m and N s/m of the controller
TIME_STEP = 1e-3  # s
DECLARED = MappingProxyType({"q": "v", "v": "b*F - c*v"})


@dataclass(frozen=True, eq=False)
class Drive:
    """Raw records of a simulated drive, and its true equations.

    Attributes
    ----------
    train, test : MeasuredRecord
        t in s, y the encoder position in m, u the motor force in N; clean q and v in `extras`.
        The test record follows another reference.
    equations : Equations
        The true equations.
    declared : mapping of str to str
        Declared model of the axis, with viscous friction only.
    """

    train: MeasuredRecord
    test: MeasuredRecord
    equations: Equations
    declared: Mapping[str, str] = field(default_factory=lambda: DECLARED)


def friction_drive(
    *,
    friction: float = FRICTION,
    noise: float = 5e-6,
    resolution: float = 1e-6,
    duration: float = 20.0,
    random_state: int | None = 0,
) -> Drive:
    """Simulate a linear axis whose declared model lacks Coulomb friction.

    Parameters
    ----------
    friction : float
        Coulomb friction Fc, N.
    noise : float
        Standard deviation of the white noise of the encoder, m.
    resolution : float
        Step of the encoder, m; 0 for none.
    duration : float
        Length of each record, s, at 1 kHz.
    random_state : int, optional
        Seed of the references and of the noise.

    Returns
    -------
    Drive

    Raises
    ------
    ValueError
        If a parameter is out of range.

    Examples
    --------
    >>> drive = friction_drive(duration=2.0)
    >>> drive.train.y.shape, drive.train.inputs, dict(drive.declared)
    ((2000, 1), ('F',), {'q': 'v', 'v': 'b*F - c*v'})
    """
    return _made("friction_drive", friction, noise, resolution, duration, random_state)


def nothing_missing(
    *,
    noise: float = 5e-6,
    resolution: float = 1e-6,
    duration: float = 20.0,
    random_state: int | None = 0,
) -> Drive:
    """Simulate the same axis without dry friction: the declared model is complete.

    Parameters
    ----------
    noise, resolution : float
        Of the encoder, m, as in `friction_drive`.
    duration : float
        Length of each record, s.
    random_state : int, optional
        Seed of the references and of the noise.

    Returns
    -------
    Drive

    Raises
    ------
    ValueError
        If a parameter is out of range.
    """
    return _made("nothing_missing", 0.0, noise, resolution, duration, random_state)


def _made(
    owner: str,
    friction: float,
    noise: float,
    resolution: float,
    duration: float,
    random_state: int | None,
) -> Drive:
    _check(owner, friction, noise, resolution, duration)
    # Without a seed every call makes another drive, so the cache is not used.
    make = _drive.__wrapped__ if random_state is None else _drive
    return make(friction, noise, resolution, duration, random_state)


@lru_cache(maxsize=32)
def _drive(
    friction: float, noise: float, resolution: float, duration: float, random_state: int | None
) -> Drive:
    seeds = np.random.SeedSequence(random_state).spawn(2)
    plant = _plant(friction)
    train, test = (
        _record(name, plant, noise, resolution, duration, np.random.default_rng(seed))
        for name, seed in zip(("train", "test"), seeds, strict=True)
    )
    return Drive(train, test, plant)


def _record(
    name: str,
    plant: Equations,
    noise: float,
    resolution: float,
    duration: float,
    rng: np.random.Generator,
) -> MeasuredRecord:
    t = np.arange(round(duration / TIME_STEP)) * TIME_STEP
    reference = _reference(t, rng)
    x = simulate(_controlled(plant), [reference[0], 0.0], t, reference)
    force = GAINS[0] * (reference - x[:, 0]) - GAINS[1] * x[:, 1]
    position = x[:, 0] + noise * rng.standard_normal(len(t))
    if resolution:
        position = resolution * np.round(position / resolution)
    columns = (t, position[:, None], force[:, None], x[:, 0].copy(), x[:, 1].copy())
    for column in columns:
        column.flags.writeable = False
    t, y, u, q, v = columns
    return MeasuredRecord(
        name, t, y, u, outputs=("q",), inputs=("F",), extras=MappingProxyType({"q": q, "v": v})
    )


def _reference(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the sum of five sines between 0.2 and 3 Hz, in m; slower ones have more amplitude."""
    f = np.geomspace(0.2, 3.0, 5) * rng.uniform(0.9, 1.1, 5)
    phase = rng.uniform(0.0, 2 * np.pi, 5)
    wave = np.sum(np.sin(2 * np.pi * f * t[:, None] + phase) / np.sqrt(f), axis=1)
    return STROKE * wave / np.abs(wave).max()


def _plant(friction: float) -> Equations:
    v, force = variable(1), variable(2)
    columns = [v, force] + ([call(BUILTIN["sgn"], v)] if friction else [])
    row = [-VISCOUS / MASS, 1.0 / MASS] + ([-friction / MASS] if friction else [])
    coef = np.array([[1.0, *[0.0] * (len(row) - 1)], row])
    return Equations(tuple(as_product(c) for c in columns), coef, ("q", "v"), ("F",))


def _controlled(plant: Equations) -> Equations:
    """Return the plant under F = k (r - q) - d v, with the reference r as input."""
    stiffness, damping = (gain / MASS for gain in GAINS)
    error = sub(variable(2), variable(0))
    terms = [*plant.terms, *(term for _, term in error.parts)]
    signs = [coefficient for coefficient, _ in error.parts]
    coef = np.hstack([plant.coef, np.zeros((2, 2))])
    coef[1, plant.terms.index(as_product(variable(2)))] = 0.0  # the force is not an input now
    coef[1, plant.terms.index(as_product(variable(1)))] -= damping
    coef[1, -2:] += [stiffness * sign for sign in signs]
    return Equations(tuple(terms), coef, plant.states, ("r",))


def _check(owner: str, friction: float, noise: float, resolution: float, duration: float) -> None:
    sizes = {"friction": friction, "noise": noise, "resolution": resolution}
    for name, value in sizes.items():
        if not (np.isfinite(value) and value >= 0):
            raise ValueError(
                f"{owner}({name}=...) must be at least 0; got {value!r}. Give 0 for none."
            )
    if not (np.isfinite(duration) and duration >= 1.0):
        raise ValueError(
            f"{owner}(duration=...) must be at least 1 s; got {duration!r}. Ask for a longer one."
        )
