"""pyoperon: genetic programming in C++."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from pyoperon.sklearn import SymbolicRegressor
from run import Data, Found

SYMBOLS = "add,sub,mul,div,abs,constant,variable"


def single_10(data: Data, seed: int) -> Found:
    """One objective (R2), 5 000 rows, population 1 000, ten steps of Levenberg-Marquardt on the
    constants of each individual, 10 s; + - * / abs, as there is no sgn: v / abs(v) has to do. Its
    limit is one of wall time, longer by as much as the machine is slowed down by others."""
    return _single(data, seed, 10)


def single_60(data: Data, seed: int) -> Found:
    """The same for 60 s."""
    return _single(data, seed, 60)


def two_objectives(data: Data, seed: int) -> Found:
    """NSGA-II on R2 and length, 2 000 rows, 20 s, the model of the front with the least BIC."""
    options = {
        "objectives": ["r2", "length"],
        "model_selection_criterion": "bayesian_information_criterion",
        "max_length": 40,
    }
    return _fitted(data, seed, 2000, max_time=load(20), **options)


def _single(data: Data, seed: int, seconds: int) -> Found:
    return _fitted(data, seed, 5000, max_time=load(seconds))


def load(seconds: float) -> int:
    """Return the wall time that a process needs for so much CPU time, from a trial of 1 s."""
    wall, cpu = time.perf_counter(), time.process_time()
    while time.perf_counter() - wall < 1.0:
        pass
    return round(seconds / (time.process_time() - cpu))


def _fitted(data: Data, seed: int, n_rows: int, **options: Any) -> Found:
    size = np.sqrt(np.mean(data.columns**2, axis=0))
    rows = np.sort(np.random.default_rng(seed).choice(len(data.a), n_rows, replace=False))
    model = SymbolicRegressor(
        allowed_symbols=SYMBOLS,
        optimizer_iterations=10,
        population_size=1000,
        generations=1_000_000,
        max_evaluations=1_000_000_000,
        epsilon=1e-12,
        n_threads=1,
        random_state=seed,
        **options,
    )
    model.fit(data.columns[rows] / size, data.a[rows])
    return Found(model.get_model_string(model.model_, 6), lambda z: model.predict(z / size))


METHODS = {
    "pyoperon, one objective, 10 s": single_10,
    "pyoperon, one objective, 60 s": single_60,
    "pyoperon, NSGA-II, BIC, 20 s": two_objectives,
}
