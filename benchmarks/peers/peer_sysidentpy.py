"""SysIdentPy: forward regression with orthogonal least squares."""

from __future__ import annotations

import numpy as np
from run import Data, Found
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares


def frols(data: Data, seed: int) -> Found:
    """FROLS over polynomials of degree 3 in q, v, zdd and sgn(v), which somebody had to know; up
    to 15 terms, their number chosen by BIC; least squares; the acceleration alone."""
    size = np.sqrt(np.mean(data.columns**2, axis=0))

    def lagged(z: np.ndarray) -> np.ndarray:
        columns = np.column_stack([z / size, np.sign(z[:, 1])])
        # Inputs act one sample later; the first two outputs stand for what was before the record.
        return np.vstack([columns[0], columns, columns[-1]])

    model = FROLS(
        order_selection=True,
        estimator=LeastSquares(),
        n_info_values=15,
        info_criteria="bic",
        model_type="NFIR",
        xlag=[[1]] * 4,
        basis_function=Polynomial(degree=3),
    )
    model.fit(X=lagged(data.columns), y=np.r_[data.a[:1], data.a[:1], data.a][:, None])
    names = np.array(["1", "q", "v", "zdd", "sgn(v)"])
    terms = [" ".join(names[code // 1000 - 1] for code in row if code) for row in model.final_model]
    weights = model.theta.ravel()
    equation = " + ".join(f"{w:.6g} {term}" for w, term in zip(weights, terms, strict=True))
    return Found(
        f"{equation}, variables over {size}",
        lambda z: model.predict(X=lagged(z), y=np.zeros((len(z) + 2, 1)), steps_ahead=1)[2:, 0],
    )


METHODS = {"SysIdentPy FROLS, sgn by hand": frols}
