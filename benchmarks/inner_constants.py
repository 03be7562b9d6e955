"""Does the search find terms with numbers inside, such as x/(0.8 + x)?

    python benchmarks/inner_constants.py          # eight seeds of each equation, 1 % of noise
    python benchmarks/inner_constants.py --noise 0.05 --seeds 4 --n-jobs 2

An equation counts as found if it is exact to a fifth of the noise and has no more terms than the
truth. The data are rows in no order, so nothing is smoothed: only the search is asked.
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed

from pysindy_evolve.evolution import evolve
from pysindy_evolve.library import OPERATORS
from pysindy_evolve.operators import resolve

RATES = ("add", "mul", "div", "exp")


@dataclass(frozen=True)
class Equation:
    """A right-hand side of x and y, its number of terms, and what may be in it."""

    truth: object
    n_terms: int
    operators: tuple = OPERATORS
    shift: float = 0.0  # of x, which is positive without it


EQUATIONS = {
    "2 sin(1.3 y) - x/2": Equation(lambda x, y: 2 * np.sin(1.3 * y) - 0.5 * x, 2),
    "x/(0.8 + x) - 0.3 x": Equation(lambda x, y: x / (0.8 + x) - 0.3 * x, 2),
    "exp(-0.6 x) + y/2": Equation(lambda x, y: np.exp(-0.6 * x) + 0.5 * y, 2, RATES),
    "x y/(1 + 0.3 x) - y": Equation(lambda x, y: x * y / (1 + 0.3 * x) - y, 2),
    "x exp(-0.4 x) - 0.2 x": Equation(lambda x, y: x * np.exp(-0.4 * x) - 0.2 * x, 2, RATES),
    "y exp(-x/1.5) + x": Equation(lambda x, y: y * np.exp(-x / 1.5) + x, 2, RATES),
    "-9.8 sin(x - 2) - 0.3 y": Equation(lambda x, y: -9.8 * np.sin(x - 2) - 0.3 * y, 3),
    "x - x^3 + y/2": Equation(lambda x, y: x - x**3 + 0.5 * y, 3, shift=-2.0),
    "2 x - x y - 0.3 y": Equation(lambda x, y: 2 * x - x * y - 0.3 * y, 3),
}


def run(name, seed, noise):
    equation, rng = EQUATIONS[name], np.random.default_rng(100 + seed)
    x = rng.uniform(0.2, 4.0, size=(1500, 2)) + equation.shift
    clean = equation.truth(*x.T)
    y = clean + noise * clean.std() * rng.normal(size=len(x))
    begin = time.process_time()
    found = evolve(x, y, operators=resolve(equation.operators), rng=np.random.default_rng(seed))
    seconds = time.process_time() - begin
    fit = sum(c * term.evaluate(x) for c, term in zip(found.coef, found.terms, strict=True))
    exact = np.std(fit - clean) < 0.2 * noise * np.std(clean)
    return exact and len(found.terms) <= equation.n_terms, len(found.terms), seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--noise", type=float, default=0.01, help="share of the spread")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--n-jobs", type=int, default=1)
    given = parser.parse_args()
    calls = [(name, seed, given.noise) for name in EQUATIONS for seed in range(given.seeds)]
    results = Parallel(n_jobs=given.n_jobs)(delayed(run)(*call) for call in calls)
    for name in EQUATIONS:
        own = [r for r, call in zip(results, calls, strict=True) if call[0] == name]
        terms, seconds = np.median([r[1] for r in own]), np.mean([r[2] for r in own])
        count = f"{sum(r[0] for r in own)} of {len(own)}"
        print(f"{name:26}{count:>8}  {terms:3.0f} terms {seconds:5.1f} s")
    print(f"{'all':26}{sum(r[0] for r in results):3} of {len(results)}")


if __name__ == "__main__":
    main()
