"""Measured records, each given to the loop with the same defaults: `python benchmarks/measured.py`.

Only the declared model and the record differ. Each case runs in a process of its own, so that its
peak memory is its own. Name cases to run only those: `python benchmarks/measured.py emps`.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

import pysindy_evolve as pse
from pysindy_evolve.datasets import MeasuredRecord
from pysindy_evolve.loop.runs import free_run

FRICTION = {
    "Coulomb friction",
    "asymmetric Coulomb friction",
    "Stribeck friction",
    "position-dependent friction",
}
COULOMB = {"Coulomb friction", "asymmetric Coulomb friction"}


@dataclass(frozen=True)
class Run:
    """A held-out record on which the free run is judged: unit of the error, and the bound on it."""

    record: pse.Record
    unit: str
    limit: float


@dataclass(frozen=True)
class Split:
    """Prepared records of one case, and the free runs to judge; the first is `test` itself."""

    train: list[pse.Record]
    test: pse.Record
    runs: tuple[Run, ...]


@dataclass(frozen=True)
class Case:
    """A declared model, its records, and what must come out."""

    equations: dict[str, str]
    inputs: tuple[str, ...]
    split: Callable[..., Split]
    named: Callable[[set[str]], bool]
    target: str
    derivative_limit: float = np.inf

    @property
    def declared(self) -> pse.DeclaredModel:
        """The model that the loop starts from."""
        return pse.DeclaredModel(self.equations, inputs=self.inputs)


@dataclass(frozen=True)
class Result:
    """What came out of one case."""

    verdict: str
    effects: tuple[str, ...]
    derivative: tuple[float, float]
    runs: tuple[tuple[float, float, str], ...]
    reached: dict[str, bool]
    seconds: float
    megabytes: float
    text: str


def prepared(record: MeasuredRecord) -> pse.Record:
    return pse.prepare(record.t, record.y, record.u)


def emps(folder=None) -> Split:
    data = pse.datasets.load_emps(folder)
    train, test = prepared(data["train"]), prepared(data["pulses"])
    return Split([train], test, (Run(test, "mm", 15.0),))


def pendulum(folder=None) -> Split:
    data = pse.datasets.load_pendulum(folder)
    train, test = prepared(data["first"]), prepared(data["rest"])
    start = test[: int(np.searchsorted(test.t, test.t[0] + 18.0))]
    return Split([train], test, (Run(start, "%", 3.0),))


def silverbox(folder=None) -> Split:
    data = pse.datasets.load_silverbox(folder)
    train, test, arrow = (prepared(data[name]) for name in ("train", "multisine", "arrow"))
    return Split([train], test, (Run(test, "mV", 1.0), Run(arrow, "mV", 2.0)))


def cart(left_out: str) -> Callable[..., Split]:
    def split(folder=None) -> Split:
        data = pse.datasets.load_cart(folder)
        records = {one.name: prepared(one) for one in (*data.train, *data.test)}
        test = records.pop(left_out)
        return Split(list(records.values()), test, (Run(test, "mm", np.inf),))

    return split


CASES = {
    "emps": Case(
        {"q": "v", "v": "b*F - c*v"},
        ("F",),
        emps,
        lambda names: bool(names & COULOMB) and "constant offset" in names,
        "Coulomb friction and offset, derivative ≤ 8 %, run ≤ 15 mm",
        derivative_limit=8.0,
    ),
    "pendulum": Case(
        {"theta": "omega", "omega": "a*sin(theta) - b*omega"},
        (),
        pendulum,
        lambda names: bool(names & COULOMB),
        "Coulomb friction, run over 18 s ≤ 3 %",
    ),
    "silverbox": Case(
        {"y": "v", "v": "a*u - b*v - c*y"},
        ("u",),
        silverbox,
        lambda names: "cubic stiffness" in names and not names & FRICTION,
        "cubic stiffness, no friction, run ≤ 1.0 mV, arrow ≤ 2 mV",
    ),
} | {
    f"cart without {gain}": Case(
        {"z": "v", "v": "a*u - b*v"}, ("u",), cart(gain), lambda names: not names, "complete"
    )
    for gain in ("kP=2.5", "kP=5", "kP=10", "kP=20")
}


def run_error(equations, run: Run) -> float:
    """RMSE of the first state in mm or mV (of data in m and V), or in % of its deviation."""
    measured = run.record.x[:, 0]
    simulated = free_run(equations, run.record, on_divergence="nan")[:, 0]
    rms = float(np.sqrt(np.mean((simulated - measured) ** 2)))
    return 100 * rms / measured.std() if run.unit == "%" else 1000 * rms


def measure(name: str, folder=None, seed: int = 0) -> Result:
    """Run one case from its raw records to the report."""
    case, start = CASES[name], time.perf_counter()
    split = case.split(folder)
    report = pse.close_loop(case.declared, split.train, test=split.test, random_state=seed)
    seconds = time.perf_counter() - start
    runs = tuple(
        (run_error(report.before.model, run), run_error(report.after.model, run), run.unit)
        for run in split.runs
    )
    derivative = (report.before.derivative_error[1], report.after.derivative_error[1])
    effects = tuple(effect.name for effect in report.effects)
    reached = {
        "names": case.named(set(effects)),
        "derivative": derivative[1] <= case.derivative_limit,
        "free run": all(
            after <= run.limit for run, (_, after, _) in zip(split.runs, runs, strict=True)
        ),
    }
    return Result(
        report.verdict, effects, derivative, runs, reached, seconds, peak_memory(), str(report)
    )


def in_new_process(name: str, folder=None, seed: int = 0) -> Result:
    pool = multiprocessing.get_context("spawn").Pool(1)
    result = pool.apply(measure, (name, folder, seed))
    pool.close()
    pool.join()
    return result


def peak_memory() -> float:
    """Largest resident size of this process so far, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)


def row(label: str, name: str, result: Result) -> list[str]:
    def runs(side: int) -> str:
        return ", ".join(f"{run[side]:.3g} {run[2]}" for run in result.runs)

    missed = [what for what, reached in result.reached.items() if not reached]
    return [
        label,
        f"{result.derivative[0]:.3g} %, {runs(0)}",
        f"{result.derivative[1]:.3g} %, {runs(1)}",
        ", ".join(result.effects) or result.verdict,
        CASES[name].target,
        "no: " + ", ".join(missed) if missed else "yes",
        f"{result.seconds:.0f} s",
        f"{result.megabytes:.0f} MB",
    ]


HEAD = ["record", "declared: derivative, run", "after", "effects", "target", "reached"]
HEAD += ["time", "peak"]


def table(rows: Sequence[Sequence[str]]) -> str:
    """Align columns as a Markdown table."""
    lines = [HEAD, *rows]
    widths = [max(len(line[k]) for line in lines) for k in range(len(HEAD))]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(
        "| "
        + " | ".join(f"{cell:<{width}}" for cell, width in zip(line, widths, strict=True))
        + " |"
        for line in lines
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", nargs="*", help=f"any of {', '.join(CASES)}; all by default")
    parser.add_argument("--folder", help="folder of the measured sets; searched for by default")
    parser.add_argument("--reports", action="store_true", help="print the whole reports too")
    parser.add_argument("--seeds", type=int, default=1, help="runs of each case, from seed 0 on")
    given = parser.parse_args()
    names = [name for name in CASES if not given.case or name.split()[0] in given.case]
    names += [name for name in given.case if name in CASES and name not in names]
    if not names:
        parser.error(f"case must be any of {', '.join(CASES)}")
    rows = []
    for name, seed in product(names, range(given.seeds)):
        result = in_new_process(name, given.folder, seed)
        if given.reports:
            print(f"\n== {name}, seed {seed}\n\n{result.text}", flush=True)
        label = f"{name}, seed {seed}" if given.seeds > 1 else name
        rows.append(row(label, name, result))
        print(f"{rows[-1][0]}: {result.seconds:.0f} s", file=sys.stderr, flush=True)
    print(table(rows))


if __name__ == "__main__":
    main()
