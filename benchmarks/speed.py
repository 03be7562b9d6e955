"""Times that a continuous benchmark follows over commits.

    pip install -e .[speed]
    OMP_NUM_THREADS=1 pytest benchmarks/speed.py -o addopts= --benchmark-autosave
    pytest-benchmark compare

Each test is one step that a user waits for, on the paper's rig with friction: 279 000 rows, 20 dB
of noise on the acceleration. Processor time of one thread; the minimum says what the code costs,
the rest is what else the machine does. Each result is checked, so a fast wrong answer fails.
"""

from __future__ import annotations

import time

import numpy as np
import pysindy as ps
import pytest

import pysindy_evolve as pse
from pysindy_evolve.breeding.dictionary import Problem
from pysindy_evolve.breeding.generation import Settings
from pysindy_evolve.breeding.genetics import Genetics
from pysindy_evolve.datasets import DuffingRig, duffing
from pysindy_evolve.evolution import evolve
from pysindy_evolve.operators import resolve
from pysindy_evolve.terms import Product, Variable

OPERATORS = ("add", "sub", "mul", "abs", "sgn")
TRUE = {"q", "v", "zdd", "q^3", "sgn(v)", "q^2 sgn(v)"}
pytestmark = pytest.mark.benchmark(timer=time.process_time, warmup=False)


@pytest.fixture(scope="module")
def rig() -> DuffingRig:
    return duffing(friction=True, experiment=1, snr_db=20.0, random_state=0)


@pytest.fixture(scope="module")
def rows(rig):
    return np.hstack([rig.x, rig.u])[rig.train], rig.x_dot[rig.train, 1]


def fit(library, optimizer, rig):
    model = ps.SINDy(feature_library=library, optimizer=optimizer)
    return model.fit(
        rig.x[rig.train], rig.t[rig.train], x_dot=rig.x_dot[rig.train], u=rig.u[rig.train],
        feature_names=list(rig.names),
    )  # fmt: skip


def test_whole_fit_inside_pysindy(benchmark, rig):
    def run():
        return fit(pse.EvolvingLibrary(OPERATORS, random_state=0), pse.ElasticNet(), rig)

    model = benchmark.pedantic(run, rounds=5)
    used = model.coefficients()[1] != 0.0
    assert {n for n, use in zip(model.get_feature_names(), used, strict=True) if use} == TRUE


def test_rival_fixed_library_with_sgn_by_hand(benchmark, rig):
    signs = ps.CustomLibrary(
        [lambda a: np.sign(a), lambda a, b: a * a * np.sign(b)],
        [lambda a: f"sgn({a})", lambda a, b: f"{a}^2 sgn({b})"],
    )
    library = ps.PolynomialLibrary(degree=3) + signs
    model = benchmark.pedantic(lambda: fit(library, ps.STLSQ(), rig), rounds=5)
    assert model.coefficients().shape[0] == 2


def test_search_alone(benchmark, rows):
    x, y = rows

    def run():
        settings = Settings(n_generations=10, patience=10)
        rng = np.random.default_rng(0)
        return evolve(x[::20], y[::20], operators=resolve(OPERATORS), rng=rng, settings=settings)

    assert benchmark.pedantic(run, rounds=3).terms


def test_refit_of_an_elastic_net_on_all_rows(benchmark, rows):
    x, y = rows
    theta = np.column_stack([x, x[:, 0] ** 3, np.sign(x[:, 1]), x[:, 0] ** 2 * np.sign(x[:, 1])])
    model = benchmark.pedantic(lambda: pse.ElasticNet().fit(theta, y), rounds=5)
    assert np.count_nonzero(model.coef_) == len(TRUE)


def test_breeding_of_one_generation(benchmark):
    parents = [Product(((Variable(i), n),)) for i in range(3) for n in (1, 2, 3)]

    def run():
        rng = np.random.default_rng(0)
        genetics = Genetics(resolve(OPERATORS), np.ones(3), max_depth=4, rng=rng)
        return genetics.offspring(
            parents, np.arange(9.0), 80, crossover_rate=0.9, mutation_rate=0.1
        )

    assert len(benchmark.pedantic(run, rounds=5)) > 60


def test_evaluation_of_a_thousand_columns(benchmark, rows):
    x, y = rows
    factors = [(Variable(i), n) for i in range(3) for n in (1, 2, 3)]
    terms = [Product((a, b)) for a in factors for b in factors if a[0].index < b[0].index]
    problem = Problem(x[:3000], y[:3000], np.empty((3000, 0)))
    theta = benchmark.pedantic(lambda: [problem.theta(terms) for _ in range(37)], rounds=5)
    assert theta[0].shape == (3000, 27)
