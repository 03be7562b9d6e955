"""Textbook systems that nobody chose for the loop: nothing missing, and each term missing in turn.

    python benchmarks/odebench.py                        # nulls and effects, 0.5 % of noise
    python benchmarks/odebench.py --noise 2 --systems 26 31 54

Each of the 63 systems of ODEBench runs from three states, the two of the benchmark and one between
them: two records to fit, one held out, each of 1000 samples and its own noise, a share of each
state's standard deviation. All terms of the truth have free coefficients in the declared model; a
missing one counts if the other terms of its equation leave 5 % of the rate without it. Right is the
term itself, or a model whose free run on the held-out record is at most 1.2 times as far off as
that of the model that lacks nothing.
"""

import argparse
import json

import numpy as np
import sympy
from joblib import Parallel, delayed
from scipy.integrate import solve_ivp
from tqdm import tqdm

import pysindy_evolve as pse

N_SAMPLES = 1000
LEAST = 0.05  # of the RMS rate, that a missing term leaves
AS_GOOD = 1.2  # times the free run of the model that lacks nothing


class System:
    """One system of ODEBench, its equations as lists of terms."""

    def __init__(self, system):
        self.number, self.name, self.t_span = system.number, system.name, system.t_span
        self.states = sympy.symbols([f"x_{i}" for i in range(len(system.equations))], real=True)
        known = {state.name: state for state in self.states}
        sides = [sympy.sympify(text.replace("^", "**"), known) for text in system.equations]
        sides = [side.replace(sympy.cot, lambda a: sympy.cos(a) / sympy.sin(a)) for side in sides]
        self.terms = [sympy.Add.make_args(sympy.expand(side)) for side in sides]
        one, other = system.initial_states
        self.starts = (one, other, 0.6 * one + 0.4 * other)

    def runs(self):
        """Integrate from each start; None if a run leaves every number behind."""
        rates = sympy.lambdify([self.states], [sum(terms) for terms in self.terms])
        t = np.linspace(*self.t_span, N_SAMPLES)
        options = {"t_eval": t, "method": "LSODA", "rtol": 1e-10, "atol": 1e-12}
        runs = [solve_ivp(lambda _, x: rates(x), self.t_span, x0, **options) for x0 in self.starts]
        return t, [run.y.T for run in runs] if all(run.success for run in runs) else None

    def declare(self, missing=None):
        """Return the model with a free coefficient for each term but one."""
        sides = {}
        for i, terms in enumerate(self.terms):
            kept = [term for j, term in enumerate(terms) if (i, j) != missing]
            if len(terms) == 1 and terms[0].is_Symbol:  # the rate of a position
                sides[f"x_{i}"] = terms[0]
                continue
            free = [sympy.Symbol(f"p{i}_{j}") for j in range(len(kept))]
            bare = [term.as_coeff_Mul()[1] for term in kept]
            sides[f"x_{i}"] = sum((p * term for p, term in zip(free, bare, strict=True)), 0)
        return pse.DeclaredModel(sides)

    def may_miss(self, runs):
        """Return the places of the terms that the others of their equation cannot replace."""
        x, places = np.concatenate(runs).T, []
        for i, terms in enumerate(self.terms):
            values = [sympy.lambdify(self.states, term)(*x) for term in terms]
            columns = np.array([np.broadcast_to(v, x.shape[1]) for v in values], dtype=float).T
            for j in range(len(terms) if len(terms) > 1 else 0):
                others = np.delete(columns, j, axis=1)
                fit = others @ np.linalg.lstsq(others, columns[:, j], rcond=None)[0]
                left = np.sqrt(np.mean((columns[:, j] - fit) ** 2))
                if left > LEAST * np.sqrt(np.mean(columns.sum(axis=1) ** 2)):
                    places.append((i, j))
        return places


def measure(system, percent, seed):
    """Return prepared records of the three runs, and the runs themselves."""
    t, runs = system.runs()
    rng = np.random.default_rng([seed, system.number])
    noisy = [x + percent / 100.0 * x.std(axis=0) * rng.standard_normal(x.shape) for x in runs]
    return [pse.prepare(t, y, order=1) for y in noisy], runs


def run(system, percent, seed):
    """Yield a row for the system as it is, and one for each term that may be missing."""
    records, runs = measure(system, percent, seed)
    whole = pse.close_loop(system.declare(), records[:2], records[2:], random_state=seed)
    bound = AS_GOOD * np.max(whole.before.simulation_error)
    case = {"system": system.number, "name": system.name, "percent": percent}
    rows = [case | row(whole)]
    for i, j in system.may_miss(runs):
        declared = system.declare((i, j))
        report = pse.close_loop(declared, records[:2], records[2:], random_state=seed)
        term = system.terms[i][j].as_coeff_Mul()[1]
        first = report.effects[0] if report.effects else None
        is_term = first is not None and first.state == f"x_{i}" and is_same(first.term, term)
        is_close = bool(np.max(report.after.simulation_error) <= bound)
        lacks = {"lacks": f"x_{i}: {term}", "is_term": is_term, "is_close": is_close}
        rows.append(case | lacks | row(report))
    return rows


def is_same(term, truth):
    """Tell whether a term is the truth times a number, where the states are positive at least."""
    positive = {s: sympy.Symbol(s.name, positive=True) for s in term.free_symbols}
    truth = truth.subs({s: positive.get(s, s) for s in truth.free_symbols})
    return bool(sympy.simplify(term.subs(positive) / truth).is_number)


def row(report):
    return {
        "verdict": report.verdict,
        "effects": [f"{e.state}: {e.name} {e.term}" for e in report.effects],
        "free_run": [float(error) for error in report.after.simulation_error],
    }


def show(rows):
    nulls = [row for row in rows if "lacks" not in row]
    effects = [row for row in rows if "lacks" in row]
    named = sum(bool(row["effects"]) for row in nulls)
    print(f"nothing missing: {named} of {len(nulls)} systems had something named")
    count = {key: sum(row[key] for row in effects) for key in ("is_term", "is_close")}
    right = sum(row["is_term"] or row["is_close"] for row in effects)
    silent = sum(row["verdict"] != "traced" for row in effects)
    print(f"a term missing: {right} of {len(effects)} right ({count['is_term']} the term itself, "
          f"{count['is_close']} runs as close), {silent} not traced")  # fmt: skip
    for row in effects:
        if not (row["is_term"] or row["is_close"]):
            print(
                f"    {row['system']} {row['lacks']}: {row['verdict']}", *row["effects"], sep="; "
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--noise", type=float, default=0.5, help="percent")
    parser.add_argument("--systems", nargs="+", type=int, help="numbers, from 1 to 63")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--n-jobs", type=int, default=1)
    parser.add_argument("--json", help="append all rows to this file, one a line")
    given = parser.parse_args()
    wanted = [
        System(s) for s in pse.datasets.load_odebench()
        if given.systems is None or s.number in given.systems
    ]  # fmt: skip
    calls = [delayed(run)(system, given.noise, given.seed) for system in wanted]
    rows = []
    for found in tqdm(Parallel(given.n_jobs, return_as="generator")(calls), total=len(calls)):
        rows += found
        if given.json:
            with open(given.json, "a") as file:
                file.writelines(json.dumps(row) + "\n" for row in found)
    show(rows)


if __name__ == "__main__":
    main()
