"""The paper's Duffing rigs, simulated, with and without dry friction.

======  ===========  ==============================================================
symbol  shape        meaning
======  ===========  ==============================================================
q       (n,)         displacement of the mass relative to the table, m
v       (n,)         its velocity, m/s
a       (n,)         its acceleration, m/s^2
zdd     (n,)         acceleration of the table, m/s^2: the input
======  ===========  ==============================================================

Without friction, equation (3): a = -(c/m) v - (k/m) q - (k3/m) q^3 - zdd. With friction, equation
(7), there are -(mu1/m) sgn(v) - (mu2/m) q^2 sgn(v) as well. The frequency of the table sweeps up,
slowly enough for the record to hold the jump from the large motion to the small one.

References
----------
Goharoodi, Dekemele, Loccufier, Dupre, Crevecoeur, Mathematical Problems in Engineering 2020,
7286575, doi:10.1155/2020/7286575; equations (3) and (7), tables 2 and 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from .. import checks
from ..equations import Equations
from ..operators import BUILTIN
from ..signals import Record, integrate
from ..simulation import simulate
from ..terms import as_product, call, mul, power, variable

TIME_STEP = 0.488e-3  # s
# v, q, q^3, zdd: -c/m, -k/m, -k3/m, -1. c in N s/m, k in N/m, k3 in N/m^3, m in kg.
FRICTIONLESS = (-1.8 / 0.49, -487.0 / 0.49, -1.07e6 / 0.49, -1.0)
# Table 4: v, q, q^3, sgn v, q^2 sgn v, zdd.
EXPERIMENTS = {
    1: (-1.10, -691.92, -2.37e6, -2.93, -7.63e3, -1.02),
    2: (-1.23, -714.60, -2.24e6, -4.11, -8.23e3, -1.04),
    3: (-1.22, -716.11, -2.35e6, -3.81, -8.26e3, -1.04),
}
# Samples for validation, which come first, and in all (60 s and 180 s), without and with friction.
SIZES = {False: (16_000, 123_000), True: (90_000, 369_000)}
HIGHEST = 900.0  # Hz, end of the accelerometers' band; a lower one would smear the jumps of a


@dataclass(frozen=True, eq=False)
class DuffingRig:
    """A simulated rig: the true motion and equations, and the measured signals.

    Attributes
    ----------
    t, q, v, a, zdd : ndarray of shape (n_samples,)
        Time in s and the clean motion; see the table of the module.
    x : ndarray of shape (n_samples, 2)
        Measured displacement and velocity.
    x_dot : ndarray of shape (n_samples, 2)
        Measured velocity and acceleration.
    u : ndarray of shape (n_samples, 1)
        Measured acceleration of the table.
    equations : Equations
        The true equations.
    validation, train : slice
        Samples to judge on, which come first, and samples to fit on.
    """

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    zdd: np.ndarray
    x: np.ndarray
    x_dot: np.ndarray
    u: np.ndarray
    equations: Equations
    validation: slice
    train: slice

    @property
    def names(self) -> tuple[str, str, str]:
        """Names of the columns of x and u, as `ps.SINDy.fit` takes them."""
        return ("q", "v", "zdd")

    def record(self, part: Literal["train", "validation"]) -> Record:
        """Return the measured signals of one part, as a record for the loop."""
        checks.choice("DuffingRig.record", "part", part, ("train", "validation"))
        at = {"train": self.train, "validation": self.validation}[part]
        columns = (self.t, self.x, self.x_dot, self.u)
        t, x, x_dot, u = (column[at] for column in columns)
        return Record(t=t, x=x, x_dot=x_dot, u=u, states=("q", "v"), inputs=("zdd",))


def duffing(
    friction: bool = False,
    *,
    experiment: int = 2,
    snr_db: float | None = None,
    noise_on: Literal["target", "all"] = "target",
    accelerometers: bool = False,
    amplitude: float = 9.0,
    sweep: tuple[float, float] = (2.0, 20.0),
    n_samples: int | None = None,
    random_state: int | None = 0,
) -> DuffingRig:
    """Simulate the paper's rig on its shaking table.

    Parameters
    ----------
    friction : bool
        Simulate equation (7), with friction, instead of (3).
    experiment : {1, 2, 3}
        Row of table 4 that gives the coefficients of equation (7).
    snr_db : float, optional
        Power of a signal over that of its white Gaussian noise; at 20 dB the noise has a hundredth
        of the power. None means no noise.
    noise_on : {"target", "all"}
        Noise on the acceleration a only, or on q, v, a and zdd alike.
    accelerometers : bool
        Measure as on the real rig: one accelerometer on the mass, one on the table, each with
        noise of `snr_db`; a is their difference, q and v its band-limited integrals.
    amplitude : float
        Largest acceleration of the table, m/s^2.
    sweep : tuple of two floats
        First and last frequency of the table, Hz; the frequency grows linearly.
    n_samples : int, optional
        Samples at 0.488 ms; by default the paper's: 123 000 (60 s), the first 16 000 for
        validation; with friction 369 000 (180 s), the first 90 000. The share for validation is
        the same for any number.
    random_state : int, optional
        Seed of the noise.

    Returns
    -------
    DuffingRig

    Raises
    ------
    ValueError
        If `experiment`, `noise_on`, `snr_db` or `n_samples` is out of range.

    Notes
    -----
    The motion is simulated once in a process for each set of parameters, in about 0.5 s without
    friction and 2 s with it. If `accelerometers` is set, neither part holds the first and last
    three periods of the lowest frequency of the integration.

    Examples
    --------
    >>> rig = duffing(friction=True, snr_db=30, n_samples=4000)
    >>> rig.x.shape, rig.u.shape, rig.equations.to_sympy()[0]
    ((4000, 2), (4000, 1), v)

    Measured as on the real rig, by two noisy accelerometers and nothing else:

    >>> rig = duffing(friction=True, experiment=1, accelerometers=True, snr_db=30, n_samples=40_000)
    >>> rig.record("train").inputs
    ('zdd',)
    """
    _check(experiment, snr_db, noise_on, n_samples)
    motion = _motion(friction, experiment, amplitude, tuple(sweep), n_samples)
    t, q, v, a, zdd, equations, n_validation = motion
    rng = np.random.default_rng(random_state)
    start, stop = 0, len(t)
    if accelerometers:
        lowest = sweep[0] / 2  # integration keeps frequencies above twice this
        q_m, v_m, a_m, zdd_m = _by_accelerometers(a, zdd, snr_db, (lowest, HIGHEST), rng)
        start = int(np.ceil(3 / lowest / TIME_STEP))
        stop -= start
    else:
        a_m = noisy(a, snr_db, rng)
        others = snr_db if noise_on == "all" else None
        q_m, v_m, zdd_m = (noisy(signal, others, rng) for signal in (q, v, zdd))
    x, x_dot = np.column_stack([q_m, v_m]), np.column_stack([v_m, a_m])
    for column in (x, x_dot):
        column.flags.writeable = False
    validation, train = slice(start, n_validation), slice(n_validation, stop)
    return DuffingRig(t, q, v, a, zdd, x, x_dot, zdd_m[:, None], equations, validation, train)


def noisy(signal: np.ndarray, snr_db: float | None, rng: np.random.Generator) -> np.ndarray:
    """Add white Gaussian noise to a signal of shape (n_samples,), at a ratio of powers in dB."""
    if snr_db is None:
        return signal
    size = np.sqrt(np.mean(signal**2)) * 10 ** (-snr_db / 20)
    return signal + size * rng.standard_normal(signal.shape)


Motion = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, Equations, int]


@lru_cache(maxsize=8)
def _motion(
    friction: bool,
    experiment: int,
    amplitude: float,
    sweep: tuple[float, float],
    n_samples: int | None,
) -> Motion:
    """Simulate the clean motion: t, q, v, a, zdd, the equations, and the size of validation."""
    n_validation, n = SIZES[friction]
    if n_samples is not None:
        n_validation, n = round(n_validation * n_samples / n), n_samples
    t = np.arange(n) * TIME_STEP
    rate = (sweep[1] - sweep[0]) / (n * TIME_STEP)
    zdd = amplitude * np.sin(2 * np.pi * (sweep[0] * t + rate / 2 * t**2))
    equations = _equations(friction, experiment)
    x = simulate(equations, [0.0, 0.0], t, zdd)
    a = equations.evaluate(x, zdd)[:, 1]
    # A mass that sticks has no acceleration; sgn(0) = 0 leaves out the friction that holds it.
    if friction:
        a = np.where(x[:, 1] == 0.0, 0.0, a)
    columns = (t, x[:, 0].copy(), x[:, 1].copy(), a, zdd)
    for column in columns:
        column.flags.writeable = False
    return (*columns, equations, n_validation)


def _equations(friction: bool, experiment: int) -> Equations:
    q, v, zdd = variable(0), variable(1), variable(2)
    sign = call(BUILTIN["sgn"], v)
    columns = [v, q, power(q, 3), *([sign, mul(power(q, 2), sign)] if friction else []), zdd]
    row = EXPERIMENTS[experiment] if friction else FRICTIONLESS
    coef = np.array([[1.0, *[0.0] * (len(row) - 1)], row])
    return Equations(tuple(as_product(c) for c in columns), coef, ("q", "v"), ("zdd",))


def _by_accelerometers(
    a: np.ndarray,
    zdd: np.ndarray,
    snr_db: float | None,
    band: tuple[float, float],
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Measure q, v, a and zdd by two accelerometers, all in one frequency band."""
    mass, table = noisy(a + zdd, snr_db, rng), noisy(zdd, snr_db, rng)
    q, v, relative = integrate(mass - table, TIME_STEP, band)
    return q, v, relative, integrate(table, TIME_STEP, band).acceleration


def _check(experiment: int, snr_db: float | None, noise_on: str, n_samples: int | None) -> None:
    if experiment not in EXPERIMENTS:
        raise ValueError(
            f"duffing(experiment=...) must be 1, 2 or 3; got {experiment!r}. "
            "Choose a row of table 4."
        )
    if snr_db is not None:
        advice = "Give None for no noise."
        checks.real("duffing", "snr_db", snr_db, "finite", math.isfinite, advice)
    if noise_on not in ("target", "all"):
        raise ValueError(
            f'duffing(noise_on=...) must be "target" or "all"; got {noise_on!r}. Choose one.'
        )
    if n_samples is not None:
        advice = "Give None for the size of the paper."
        checks.integer("duffing", "n_samples", n_samples, 100, advice)
