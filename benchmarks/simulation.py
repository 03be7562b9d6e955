"""Time and error of free runs and short ones: `python benchmarks/simulation.py`.

One thread. The first free run of a structure compiles its program, the later ones do not.
"""

import argparse
import time

import numpy as np

from pysindy_evolve.datasets.rigs import duffing
from pysindy_evolve.simulation import simulate
from pysindy_evolve.simulation.pieces import simulate_pieces
from pysindy_evolve.simulation.program import program_of


def timed(function, *args, **options):
    start = time.perf_counter()
    result = function(*args, **options)
    return result, time.perf_counter() - start


def free_runs() -> None:
    print(f"{'free run':<34}{'samples':>9}{'first s':>9}{'again s':>9}{'us/sample':>11}")
    for friction in (False, True):
        rig = duffing(friction)
        for n in (12_000, 100_000):
            program_of.cache_clear()
            given = (rig.equations, [0.0, 0.0], rig.t[:n], rig.zdd[:n])
            _, first = timed(simulate, *given)
            _, again = timed(simulate, *given)
            name = "Duffing with friction (6 terms)" if friction else "Duffing (4 terms)"
            print(f"{name:<34}{n:>9}{first:>9.2f}{again:>9.2f}{1e6 * again / n:>11.1f}")


def accuracy() -> None:
    rig = duffing(friction=True)
    n = 100_000
    given = (rig.equations, [0.0, 0.0], rig.t[:n], rig.zdd[:n])
    exact = simulate(*given, tolerance=1e-13)
    print(f"\n{'tolerance of a step':<34}{'seconds':>9}{'error of q':>12}{'error of v':>12}")
    for tolerance in (1e-6, 1e-9, 1e-11):
        x, seconds = timed(simulate, *given, tolerance=tolerance)
        error = np.abs(x - exact).max(axis=0) / np.abs(exact).max(axis=0)
        print(f"{tolerance:<34.0e}{seconds:>9.2f}{error[0]:>12.1e}{error[1]:>12.1e}")


def pieces() -> None:
    rig = duffing(friction=True)
    at = slice(0, 40_000, 4)
    x, t, u = rig.x[at], rig.t[at], rig.u[at]
    spread = x.std(axis=0)
    print(f"\n{'pieces, 10 000 samples':<34}{'models':>9}{'seconds':>9}{'rms of q':>12}")
    for length in (50, 100, 500):
        rows = np.arange(0, len(t) - length, length)[:, None] + np.arange(length + 1)
        for n_models in (1, 10):
            coef = np.stack([rig.equations.coef] * n_models)
            every = np.tile(rows, (n_models, 1))
            given = coef, x[every[:, 0]], t[every], u[every]
            predicted, seconds = timed(simulate_pieces, rig.equations, *given)
            error = np.sqrt(np.mean((predicted - x[every]) ** 2, axis=(0, 1))) / spread
            print(f"{f'pieces of {length}':<34}{n_models:>9}{seconds:>9.3f}{error[0]:>12.1e}")


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    free_runs()
    accuracy()
    pieces()


if __name__ == "__main__":
    main()
