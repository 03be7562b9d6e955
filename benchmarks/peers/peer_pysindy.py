"""PySINDy with fixed libraries: as they come, with sgn put in by hand, and by brute force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pysindy as ps
from run import Data, Found

THRESHOLDS = np.logspace(-3, -0.5, 9)  # of x_dot of unit size, variables of unit RMS


def cubic(data: Data, seed: int) -> Found:
    """PolynomialLibrary(degree=3) and STLSQ() with its default threshold."""
    return _fitted(data, ps.PolynomialLibrary(degree=3))


def by_hand(data: Data, seed: int) -> Found:
    """Cubic polynomials, sgn(a) and a^2 sgn(b), which somebody had to know; STLSQ() defaults."""
    return _fitted(data, _signs_by_hand())


def cubic_swept(data: Data, seed: int) -> Found:
    """PolynomialLibrary(degree=3); variables scaled to unit RMS and x_dot to unit size, nine
    thresholds from 0.001 to 0.3, the model chosen by BIC."""
    return _swept(data, ps.PolynomialLibrary(degree=3))


def by_hand_swept(data: Data, seed: int) -> Found:
    """The terms put in by hand, scaled and swept as the cubic ones."""
    return _swept(data, _signs_by_hand())


def brute_force(data: Data, seed: int) -> Found:
    """Cubic polynomials times 1 or the sgn of each variable, 80 columns, scaled and swept."""
    signs = ps.CustomLibrary([lambda a: np.sign(a)], [lambda a: f"sgn({a})"])
    polynomials = ps.PolynomialLibrary(degree=3)
    return _swept(data, polynomials + polynomials * signs)


def _signs_by_hand() -> Any:
    return ps.PolynomialLibrary(degree=3) + ps.CustomLibrary(
        [lambda a: np.sign(a), lambda a, b: a * a * np.sign(b)],
        [lambda a: f"sgn({a})", lambda a, b: f"{a}^2 sgn({b})"],
    )


def _fitted(data: Data, library: Any) -> Found:
    model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ())
    model.fit(data.x, data.t, x_dot=data.x_dot, u=data.u, feature_names=list(data.names))
    return Found(model.equations(6)[1], lambda z: model.predict(z[:, :2], u=z[:, 2:])[:, 1])


def _swept(data: Data, library: Any) -> Found:
    size, scale = np.sqrt(np.mean(data.columns**2, axis=0)), np.std(data.x_dot, axis=0)
    x, u, x_dot = data.x / size[:2], data.u / size[2:], data.x_dot / scale
    best, least = None, np.inf
    for threshold in THRESHOLDS:
        model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=threshold))
        model.fit(x, data.t, x_dot=x_dot, u=u, feature_names=list(data.names))
        error = np.mean(np.asarray(model.predict(x, u=u) - x_dot)[:, 1] ** 2)
        bic = len(x) * np.log(error) + np.log(len(x)) * np.count_nonzero(model.coefficients()[1])
        if bic < least:
            best, least = model, bic
    equation = f"{scale[1]:.6g} * ({best.equations(6)[1]}), variables over {size}"
    return Found(
        equation, lambda z: scale[1] * best.predict(z[:, :2] / size[:2], u=z[:, 2:] / size[2])[:, 1]
    )


METHODS = {
    "PySINDy, cubic polynomials": cubic,
    "PySINDy, cubic polynomials, swept": cubic_swept,
    "PySINDy, sgn by hand": by_hand,
    "PySINDy, sgn by hand, swept": by_hand_swept,
    "PySINDy, brute force, swept": brute_force,
}
