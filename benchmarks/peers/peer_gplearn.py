"""gplearn: genetic programming with the interface of scikit-learn."""

from __future__ import annotations

import numpy as np
from gplearn.functions import make_function
from gplearn.genetic import SymbolicRegressor
from run import Data, Found


def gplearn(data: Data, seed: int) -> Found:
    """Population 250, 80 generations, + - * / abs and sgn, parsimony 0.001, variables of unit RMS
    and a target of unit size; other parameters as they come."""
    size, scale = np.sqrt(np.mean(data.columns**2, axis=0)), np.std(data.a)
    sgn = make_function(function=np.sign, name="sgn", arity=1)
    model = SymbolicRegressor(
        population_size=250,
        generations=80,
        function_set=("add", "sub", "mul", "div", "abs", sgn),
        const_range=(-5.0, 5.0),
        metric="mse",
        feature_names=data.names,
        random_state=seed,
    )
    model.fit(data.columns / size, data.a / scale)
    return Found(str(model._program), lambda z: scale * model.predict(z / size))


METHODS = {"gplearn, 250 x 80": gplearn}
