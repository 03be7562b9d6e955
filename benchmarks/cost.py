"""What a fit costs: time and memory over rows, variables, population, generations and targets.

    OMP_NUM_THREADS=1 python benchmarks/cost.py [rows variables population generations targets
                                                 brute mapped]
                                                [--most-rows 3000000] [--most-columns 3200]

Each figure comes from a process of its own, as a process never gives its peak back. The data are
oscillations with slowly changing frequencies; the equation sought has four terms, one of them
q^2 sgn(v), and 20 dB of noise. `read` is the processor time of the checks of all rows, `search`
that of the generations, `refit` that of the last step on all rows, `whole` all of
``EvolvingLibrary.fit``. Memory is the peak above what the process held with the data in it, as a
multiple of the data. See docs/cost.md.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from math import comb
from pathlib import Path

import numpy as np

OPERATORS = ("add", "sub", "mul", "abs", "sgn")
ROWS = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000)
ONE_CASE = {"rows": 100_000, "variables": 3, "targets": 1, "population": 80, "generations": 30}
STUDIES = {
    "variables": (2, 3, 5, 10, 20),
    "population": (20, 40, 80, 160, 320),
    "generations": (5, 10, 20, 40),
    "targets": (1, 2, 4, 8),
}
BRUTE_ROWS = 100_000
N_SEEDS = 3  # of the noise and of the search, of which the median is shown
N_THRESHOLDS = 9  # of a sweep, each of which costs as much as the one that is run
MAPPED_ROWS = 30_000_000
MEBI = 1 << 20


def signals(rows: int, variables: int, out: np.ndarray | None = None) -> np.ndarray:
    """Oscillations of different frequencies that wander, shape (rows, variables)."""
    x = np.empty((rows, variables)) if out is None else out
    for start in range(0, rows, 1 << 16):
        t = np.arange(start, min(start + (1 << 16), rows)) * (600.0 / rows)
        for j in range(variables):
            w = 1.0 + 0.37 * j
            slow = np.sin(0.11 * w * t + j)
            x[start : start + len(t), j] = (1.0 + 0.5 * slow) * np.sin(w * t + 2.0 * slow)
    return x


def target(x: np.ndarray, k: int, rng: np.random.Generator) -> np.ndarray:
    """Four terms of three variables, other ones for each target k, and noise."""
    a, b, c = (x[:, (k + j) % x.shape[1]] for j in range(3))
    clean = -2.0 * a - 0.7 * b + a**2 * np.sign(b) + 0.5 * c * a
    return clean + 0.1 * rng.standard_normal(len(x))


def peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


def run_search(case: dict) -> dict:
    """Fit one case in this process."""
    from pysindy_evolve import EvolvingLibrary, evolution, library

    x = signals(case["rows"], case["variables"])
    rng = np.random.default_rng(case["seed"])
    y = np.empty((len(x), case["targets"]))
    for k in range(case["targets"]):
        y[:, k] = target(x[:, :], k, rng)
    library.evolve, evolving = timed(library.evolve)
    evolution.refit, refitting = timed(evolution.refit)
    fitted = EvolvingLibrary(
        OPERATORS, population_size=case["population"], n_generations=case["generations"],
        random_state=case["seed"],
    )  # fmt: skip
    warm = EvolvingLibrary(OPERATORS, population_size=5, n_generations=1, random_state=0)
    warm.fit(x[:1000], y[:1000])  # imports and first calls are no cost of a row
    evolving.clear()
    refitting.clear()
    held, start = peak(), time.process_time()
    fitted.fit(x, y)
    whole = time.process_time() - start
    data = x.nbytes + y.nbytes
    return {
        "whole": whole, "refit": sum(refitting), "search": sum(evolving) - sum(refitting),
        "read": whole - sum(evolving), "generations": max(len(h) for h in fitted.history_),
        "memory": (peak() - held) / data, "mebibytes": (peak() - held) / MEBI,
        "terms": len(fitted.terms_),
    }  # fmt: skip


def timed(function):
    """Return the function, and a list to which each call adds its processor time."""
    spent = []

    def call(*arguments, **options):
        start = time.process_time()
        result = function(*arguments, **options)
        spent.append(time.process_time() - start)
        return result

    return call, spent


def run_brute(case: dict) -> dict:
    """Fit cubic polynomials times 1 or the sgn of each variable, one threshold of a sweep."""
    import pysindy as ps

    x = signals(case["rows"], case["variables"])
    y = target(x, 0, np.random.default_rng(case["seed"]))[:, None]
    signs = ps.CustomLibrary([lambda a: np.sign(a)], [lambda a: f"sgn({a})"])
    cubic = ps.PolynomialLibrary(degree=case["degree"])
    held, start = peak(), time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theta = np.asarray((cubic + cubic * signs).fit_transform(x))
        coef = ps.STLSQ(threshold=0.05).fit(theta, y).coef_
    return {
        "whole": time.process_time() - start, "mebibytes": (peak() - held) / MEBI,
        "terms": int(np.count_nonzero(coef)), "columns": theta.shape[1],
    }  # fmt: skip


def run_mapped(case: dict) -> dict:
    """Fit a memory-mapped file that is larger than the memory this process may take."""
    from pysindy_evolve import EvolvingLibrary

    rng = np.random.default_rng(0)
    small = signals(1000, 3)
    EvolvingLibrary(OPERATORS, population_size=5, n_generations=1).fit(small, target(small, 0, rng))
    data = np.load(case["path"], mmap_mode="r")
    limit = case["limit"]
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    held, start = anonymous(), time.process_time()
    library = EvolvingLibrary(OPERATORS, random_state=0).fit(data[:, :3], data[:, 3])
    return {
        "whole": time.process_time() - start, "limit": limit / MEBI, "file": data.nbytes / MEBI,
        "held": held / MEBI, "terms": len(library.terms_),
        "names": library.get_feature_names(["a", "b", "c"]),
    }  # fmt: skip


def anonymous() -> float:
    """Memory of this process that no file stands behind, bytes: what RLIMIT_DATA counts."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    (size,) = (line.split()[1] for line in lines if line.startswith("VmData"))
    return 1024.0 * float(size)


RUNS = {"search": run_search, "brute": run_brute, "mapped": run_mapped}


def child(kind: str, **case) -> dict:
    case = {"kind": kind, "seed": 0, **case}
    done = subprocess.run(
        [sys.executable, __file__, "--case", json.dumps(case)], capture_output=True, text=True
    )
    if done.returncode:
        return {"error": done.stderr.strip().splitlines()[-1]}
    return json.loads(done.stdout.splitlines()[-1])


def exponent(sizes, costs) -> float:
    """Power of the size that the cost grows with, by least squares on logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(np.maximum(costs, 1e-4)), 1)[0])


def study(name: str, sizes) -> None:
    head = "read s  search s  refit s  whole s  generations  memory / data     MiB  terms"
    print(f"\n{name:>12}  {head}", flush=True)
    found = {}
    for size in sizes:
        runs = [child("search", **{**ONE_CASE, name: size}, seed=seed) for seed in range(N_SEEDS)]
        errors = [run["error"] for run in runs if "error" in run]
        if errors:
            print(f"{size:12}  {errors[0]}", flush=True)
            continue
        cost = {key: float(np.median([run[key] for run in runs])) for key in runs[0]}
        found[size] = cost
        print(
            f"{size:12}{cost['read']:8.2f}{cost['search']:10.2f}{cost['refit']:9.2f}{cost['whole']:9.2f}"
            f"{cost['generations']:13.0f}{cost['memory']:15.2f}{cost['mebibytes']:8.0f}"
            f"{cost['terms']:7.0f}", flush=True,
        )  # fmt: skip
    if len(found) > 1:
        powers = {
            key: exponent(list(found), [c[key] for c in found.values()])
            for key in ("read", "search", "refit", "whole")
        }
        each = [cost["search"] / cost["generations"] for cost in found.values()]
        powers["search of a generation"] = exponent(list(found), each)
        print("   grows with" + "".join(f"  {k} ^{p:.2f}" for k, p in powers.items()))


def study_brute(most_columns: int) -> None:
    print(f"\nbrute force: polynomials x {{1, sgn of each variable}}, {BRUTE_ROWS} rows")
    print(
        "variables  degree  columns  one threshold s  nine s     MiB"
        "   ours s     MiB  faster  smaller"
    )
    for variables, degree in [*((v, 3) for v in range(3, 11)), (3, 4), (3, 5), (5, 4), (5, 5)]:
        columns = comb(variables + degree, degree) * (1 + variables)
        line = f"{variables:9}{degree:8}{columns:9}"
        if columns > most_columns:
            bytes_ = 8.0 * BRUTE_ROWS * columns / MEBI
            print(f"{line}  not run: theta alone takes {bytes_:.0f} MiB", flush=True)
            continue
        brute = child("brute", rows=BRUTE_ROWS, variables=variables, degree=degree)
        ours = child("search", **{**ONE_CASE, "rows": BRUTE_ROWS, "variables": variables})
        if "error" in brute or "error" in ours:
            print(line, brute.get("error"), ours.get("error"), flush=True)
            continue
        swept = N_THRESHOLDS * brute["whole"]
        print(
            f"{line}{brute['whole']:17.2f}{swept:8.1f}{brute['mebibytes']:8.0f}{ours['whole']:9.2f}"
            f"{ours['mebibytes']:8.0f}{swept / ours['whole']:8.1f}"
            f"{brute['mebibytes'] / max(ours['mebibytes'], 0.1):9.1f}", flush=True,
        )  # fmt: skip


def study_mapped(rows: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.npy"
        file = np.lib.format.open_memmap(path, mode="w+", dtype=float, shape=(rows, 4))
        signals(rows, 3, file)
        rng = np.random.default_rng(0)
        for start in range(0, rows, 1 << 16):
            part = slice(start, start + (1 << 16))
            file[part, 3] = target(file[part, :3], 0, rng)
        file.flush()
        size = file.nbytes
        del file
        cost = child("mapped", path=str(path), limit=int(0.99 * size))
    print(f"\nmapped file of {size / MEBI:.0f} MiB: {cost}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    names = ["rows", *STUDIES, "brute", "mapped"]
    parser.add_argument("studies", nargs="*", help=f"of {', '.join(names)}; all by default")
    parser.add_argument("--most-rows", type=int, default=ROWS[-1])
    parser.add_argument("--most-columns", type=int, default=3200, help="of a brute-force library")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.case:
        case = json.loads(arguments.case)
        print(json.dumps(RUNS[case["kind"]](case)))
        return
    for name in arguments.studies or names:
        if name == "rows":
            study(name, [n for n in ROWS if n <= arguments.most_rows])
        elif name == "brute":
            study_brute(arguments.most_columns)
        elif name == "mapped":
            study_mapped(MAPPED_ROWS)
        elif name in STUDIES:
            study(name, STUDIES[name])
        else:
            parser.error(f"no study {name!r}; choose from {', '.join(names)}")


if __name__ == "__main__":
    main()
