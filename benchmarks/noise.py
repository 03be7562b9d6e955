"""Noise on every measured channel: exact structures and coefficient errors over the noise.

    OMP_NUM_THREADS=1 python benchmarks/noise.py [--runs 20] [--snr 40 35 30 25 20] [--rig friction]

The paper's two oscillators with white noise on q, v, a and zdd alike; the rig with friction
measured by two noisy accelerometers and nothing else, the three experiments of table 4 in turn; and
a pendulum with Coulomb friction and a driven Van der Pol oscillator. All are ordinary
``ps.SINDy`` fits with default settings. `exact` counts runs whose every equation has the true terms
and no other; the coefficient error is the worst of an equation's, over the exact runs. The last
column is the error of the acceleration on clean validation data, where the mass moves.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
import pysindy as ps

import pysindy_evolve as pse
from pysindy_evolve.datasets import duffing
from pysindy_evolve.datasets.rigs import noisy
from pysindy_evolve.equations import Equations
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.simulation import simulate
from pysindy_evolve.terms import call, mul, power, variable

RIGS = ("frictionless", "friction", "accelerometers", "pendulum", "van der pol")
Q, V = variable(0), variable(1)
ENOUGH = 0.95  # of the runs must be exact for a noise to count as held


@dataclass(frozen=True)
class Problem:
    """Training data, operators and truth of one run."""

    x: np.ndarray
    x_dot: np.ndarray
    u: np.ndarray
    t: np.ndarray
    operators: tuple[str, ...]
    truth: tuple[dict[str, float], ...]
    validation: tuple[np.ndarray, np.ndarray, np.ndarray]  # clean x, u and acceleration


def problem(rig: str, snr_db: float, seed: int) -> Problem:
    if rig in ("pendulum", "van der pol"):
        return _other(rig, snr_db, seed)
    friction = rig != "frictionless"
    if rig == "accelerometers":
        data = duffing(
            friction, experiment=1 + seed % 3, snr_db=snr_db, accelerometers=True, random_state=seed
        )
    else:
        data = duffing(friction, snr_db=snr_db, noise_on="all", random_state=seed)
    train, held_out = data.train, data.validation
    names = [term.name(data.names) for term in data.equations.terms]
    rows = [dict(zip(names, row, strict=True)) for row in data.equations.coef]
    truth = tuple({name: c for name, c in row.items() if c} for row in rows)
    moves = data.v[held_out] != 0.0
    clean = (np.column_stack([data.q, data.v]), data.zdd[:, None], data.a)
    return Problem(
        data.x[train], data.x_dot[train], data.u[train], data.t[train],
        # Tables 1 and 3 of the paper.
        ("add", "sub", "mul", *(["div"] if rig == "accelerometers" else []), "abs", "sgn"),
        truth, tuple(column[held_out][moves] for column in clean),
    )  # fmt: skip


def _other(rig: str, snr_db: float, seed: int) -> Problem:
    if rig == "pendulum":
        t = np.arange(40_000) * 0.002
        u = 6 * np.sin(2 * np.pi * (0.3 * t + 0.005 * t**2)) + 2 * np.sin(7.1 * t)
        columns = {"v": V, "sin(q)": call(BUILTIN["sin"], Q), "sgn(v)": call(BUILTIN["sgn"], V)}
        row = {"v": -0.3, "sin(q)": -9.81, "sgn(v)": -0.8, "u": 1.0}
        operators = ("add", "sub", "mul", "sin", "cos", "abs", "sgn")
    else:
        t = np.arange(20_000) * 0.005
        u = 1.5 * np.sin(1.3 * t) + np.sin(0.41 * t)
        columns = {"v": V, "q^2 v": mul(power(Q, 2), V), "q": Q}
        row = {"v": 2.0, "q^2 v": -2.0, "q": -1.0, "u": 1.0}
        operators = ("add", "sub", "mul", "abs", "sgn")
    terms = tuple(column.parts[0][1] for column in (*columns.values(), variable(2)))
    coef = np.array([[1.0] + [0.0] * (len(row) - 1), list(row.values())])
    equations = Equations(terms, coef, ("q", "v"), ("u",))
    x = simulate(equations, [0.3, 0.0], t, u)
    a = equations.evaluate(x, u)[:, 1]
    rng = np.random.default_rng(seed)
    q_m, v_m, a_m, u_m = (noisy(y, snr_db, rng) for y in (x[:, 0], x[:, 1], a, u))
    return Problem(
        np.column_stack([q_m, v_m]), np.column_stack([v_m, a_m]), u_m[:, None], t, operators,
        ({"v": 1.0}, row), (x, u[:, None], a),
    )  # fmt: skip


def run(rig: str, snr_db: float, seed: int) -> tuple[bool, float, float, float]:
    """Fit once: exact or not, worst coefficient and validation error in percent, CPU seconds."""
    data = problem(rig, snr_db, seed)
    library = pse.EvolvingLibrary(operators=data.operators, random_state=seed)
    model = ps.SINDy(feature_library=library, optimizer=pse.ElasticNet())
    names = ["q", "v", "zdd" if "zdd" in data.truth[1] else "u"]
    start = time.process_time()
    model.fit(data.x, data.t, x_dot=data.x_dot, u=data.u, feature_names=names)
    seconds = time.process_time() - start
    columns, coef = model.get_feature_names(), model.coefficients()
    found = [{n: c for n, c in zip(columns, row, strict=True) if c} for row in coef]
    exact = [set(row) for row in found] == [set(row) for row in data.truth]
    pairs = [(row[n], c) for row, true in zip(found, data.truth, strict=True)
             for n, c in true.items() if n in row]  # fmt: skip
    worst = 100 * max((abs(c / true - 1) for c, true in pairs), default=np.nan)
    x, u, a = data.validation
    off = np.asarray(model.predict(x, u=u))[:, 1] - a
    return exact, worst, 100 * float(np.std(off) / np.std(a)), seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--snr", type=float, nargs="+", default=[40.0, 35.0, 30.0, 25.0, 20.0])
    parser.add_argument("--rig", choices=RIGS, nargs="+", default=list(RIGS))
    given = parser.parse_args()
    print(f"{'rig':15}{'SNR dB':>7}{'exact':>8}{'coefficients off by % (max)':>30}"
          f"{'error % (max)':>16}{'CPU s':>7}")  # fmt: skip
    for rig in given.rig:
        held = [snr for snr in sorted(given.snr, reverse=True) if row(rig, snr, given.runs)]
        lowest = f"{min(held):g} dB" if held else "none of these"
        print(f"{rig}: lowest SNR held in {ENOUGH:.0%} of the runs: {lowest}\n", flush=True)


def row(rig: str, snr_db: float, n_runs: int) -> bool:
    """Print one row and say whether enough runs were exact."""
    runs = [run(rig, snr_db, seed) for seed in range(n_runs)]
    exact = [one for one in runs if one[0]]
    worst = [one[1] for one in exact] or [np.nan]
    errors, seconds = [one[2] for one in runs], [one[3] for one in runs]
    print(
        f"{rig:15}{snr_db:7g}{len(exact):5}/{n_runs:<2}"
        f"{np.mean(worst):20.2f} ({np.max(worst):5.2f})"
        f"  {np.mean(errors):8.2f} ({np.max(errors):5.2f}){np.median(seconds):6.1f}",
        flush=True,
    )
    return len(exact) >= ENOUGH * n_runs


if __name__ == "__main__":
    main()
