"""This package, as its README says."""

from __future__ import annotations

import pysindy as ps
from run import Data, Found

import pysindy_evolve as pse


def evolve(data: Data, seed: int) -> Found:
    """EvolvingLibrary with the operators of the paper's table 1 and nothing else set; it fits both
    states, as every PySINDy row does."""
    operators = ("add", "sub", "mul", "abs", "sgn")
    library = pse.EvolvingLibrary(operators, random_state=seed)
    model = ps.SINDy(feature_library=library, optimizer=pse.ElasticNet())
    model.fit(data.x, data.t, x_dot=data.x_dot, u=data.u, feature_names=list(data.names))
    return Found(model.equations(6)[1], lambda z: model.predict(z[:, :2], u=z[:, 2:])[:, 1])


METHODS = {"pysindy_evolve": evolve}
