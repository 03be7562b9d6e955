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
from pysindy_evolve.loop.fitting.runs import free_run

FRICTION = {
    "Coulomb friction",
    "asymmetric Coulomb friction",
    "Stribeck friction",
    "position-dependent friction",
}
COULOMB = {"Coulomb friction", "asymmetric Coulomb friction"}


@dataclass(frozen=True)
class Run:
    """Held-out records on which free runs are judged together: unit of the error, bound on it."""

    records: tuple[pse.Record, ...]
    unit: str
    limit: float
    state: int = 0


@dataclass(frozen=True)
class Split:
    """Prepared records of one case, and the free runs to judge; the first is `test` itself."""

    train: list[pse.Record]
    test: pse.Record | list[pse.Record]
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
    state: int = 1
    algebraic: bool = False
    drag: Callable[..., float] | None = None

    @property
    def declared(self) -> pse.DeclaredModel:
        """The model that the loop starts from."""
        return pse.DeclaredModel(self.equations, inputs=self.inputs, algebraic=self.algebraic)


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
    return Split([train], test, (Run((test,), "mm", 15.0),))


def pendulum(folder=None) -> Split:
    data = pse.datasets.load_pendulum(folder)
    train, test = prepared(data["first"]), prepared(data["rest"])
    start = test[: int(np.searchsorted(test.t, test.t[0] + 18.0))]
    return Split([train], test, (Run((start,), "%", 2.2),))


def silverbox(folder=None) -> Split:
    data = pse.datasets.load_silverbox(folder)
    train, test, arrow = (prepared(data[name]) for name in ("train", "multisine", "arrow"))
    return Split([train], test, (Run((test,), "mV", 0.5), Run((arrow,), "mV", 1.2)))


def cart(left_out: str) -> Callable[..., Split]:
    def split(folder=None) -> Split:
        data = pse.datasets.load_cart(folder)
        records = {one.name: prepared(one) for one in (*data.train, *data.test)}
        test = records.pop(left_out)
        return Split(list(records.values()), test, (Run((test,), "mm", np.inf),))

    return split


def tclab(folder=None) -> Split:
    """Heat from rest: before the record begins, the heater is off and the board at rest."""
    data, rest = pse.datasets.load_tclab(folder), 100

    def record(name: str) -> pse.Record:
        one = data[name]
        step = (one.t[-1] - one.t[0]) / (len(one.t) - 1)
        t = one.t[0] + step * np.arange(-rest, len(one.t))
        y = np.vstack([np.repeat(one.y[:1], rest, axis=0), one.y])
        return pse.prepare(t, y, np.vstack([np.zeros((rest, 1)), one.u]), order=1)

    train, test = record("B"), record("E")
    return Split([train], test, (Run((test,), "°C", 3.5, state=1),))


def tanks(folder=None) -> Split:
    data = pse.datasets.load_cascaded_tanks(folder)
    train, test = (pse.prepare(r.t, r.y, r.u, order=1) for r in (*data.train, *data.test))
    return Split([train], test, (Run((test,), "V", 0.30),))


def damper(folder=None) -> Split:
    data = pse.datasets.load_mr_damper(folder)
    train, test = (
        [pse.signals.as_target(pse.prepare(r.t, r.u, r.y, order=2)) for r in records]
        for records in (data.train, data.test)
    )
    return Split(train, test, (Run(tuple(test), "%", 11.5),))


def ball(name: str) -> Callable[..., Split]:
    def split(folder=None) -> Split:
        data = pse.datasets.load_ball_drops(folder)
        # The last time step can be irregular, and the others are rounded: the film has 15 Hz.
        train, test = (
            pse.prepare(np.arange(len(r.t) - 1) / 15.0, r.y[:-1])
            for r in (data[f"{name}, drop 1"], data[f"{name}, drop 2"])
        )
        return Split([train], test, (Run((test,), "m", 1.2),))

    return split


def sphere(name: str) -> Callable[..., float]:
    def drag(folder=None) -> float:
        """Return 0.5 rho Cd A / m of a smooth sphere of the ball's size, 1/m."""
        known = pse.datasets.load_ball_drops(folder)[f"{name}, drop 1"].constants
        area = known["circumference"] ** 2 / (4.0 * np.pi)
        return 0.5 * 1.2 * 0.47 * area / known["mass"]

    return drag


WHIFFLES = ("Whiffle Ball 1", "Whiffle Ball 2", "Yellow Whiffle Ball", "Orange Whiffle Ball")
LIGHT = (*WHIFFLES, "Tennis Ball")
HEAVY = ("Golf Ball", "Bowling Ball")
FALL = {"h": "v", "v": "-9.81"}

CASES = (
    {
        "emps": Case(
            {"q": "v", "v": "b*F - c*v"},
            ("F",),
            emps,
            lambda names: bool(names & COULOMB) and {"constant offset", "input delay"} <= names,
            "Coulomb friction, offset and delay, derivative ≤ 5 %, run ≤ 15 mm",
            derivative_limit=5.0,
        ),
        "pendulum": Case(
            {"theta": "omega", "omega": "a*sin(theta) - b*omega"},
            (),
            pendulum,
            lambda names: bool(names & COULOMB),
            "Coulomb friction, run over 18 s ≤ 2.2 %",
        ),
        "silverbox": Case(
            {"y": "v", "v": "a*u - b*v - c*y"},
            ("u",),
            silverbox,
            lambda names: "cubic stiffness" in names and not names & FRICTION,
            "cubic stiffness, no friction, run ≤ 0.5 mV, arrow ≤ 1.2 mV",
        ),
        "tclab": Case(
            {"T1": "a*Q1 - b*T1 + c", "T2": "-d*T2 + e"},
            ("Q1",),
            tclab,
            lambda names: {"coupling", "actuator lag"} <= names,
            "coupling and actuator lag, T2 ≤ 3.5 °C",
        ),
        "cascaded_tanks": Case(
            {"h": "k1*u - k2*sqrt(h)"},
            ("u",),
            tanks,
            lambda names: {"hidden state", "saturation"} <= names,
            "hidden state, then overflow or saturation, run ≤ 0.30 V",
            state=0,
        ),
    }
    | {
        f"cart without {gain}": Case(
            {"z": "v", "v": "a*u - b*v"}, ("u",), cart(gain), lambda names: not names, "complete"
        )
        for gain in ("kP=2.5", "kP=5", "kP=10", "kP=20")
    }
    | {
        f"ball_drops {name}": Case(FALL, (), ball(name), lambda names: not names, "complete")
        for name in HEAVY
    }
)


# Run by name, and not in the tests: it takes long, or is not reached yet.
OPEN = {
    "mr_damper": Case(
        {"F": "c*v + k*x + F0"},
        ("x", "v", "a"),
        damper,
        lambda names: "hysteresis" in names,
        "friction with hysteresis, ≤ 11.5 % on the other records",
        state=0,
        algebraic=True,
    ),
} | {
    f"ball_drops {name}": Case(
        FALL,
        (),
        ball(name),
        bool,
        "quadratic drag or that among the alternatives, within 30 % of a sphere's, run ≤ 1.2 m",
        drag=sphere(name),
    )
    for name in LIGHT
}


def run_error(equations, run: Run) -> float:
    """RMSE of one state in mm or mV (of data in m and V), in its unit, or in % of its deviation."""
    measured = np.concatenate([record.x[:, run.state] for record in run.records])
    runs = [free_run(equations, record, on_divergence="nan") for record in run.records]
    simulated = np.concatenate([one[:, run.state] for one in runs])
    rms = float(np.sqrt(np.mean((simulated - measured) ** 2)))
    if run.unit == "%":
        return 100 * rms / measured.std()
    return rms if run.unit in ("m", "V", "°C") else 1000 * rms


def measure(name: str, folder=None, seed: int = 0) -> Result:
    """Run one case from its raw records to the report."""
    case, start = (CASES | OPEN)[name], time.perf_counter()
    split = case.split(folder)
    report = pse.close_loop(case.declared, split.train, test=split.test, random_state=seed)
    seconds = time.perf_counter() - start
    runs = tuple(
        (run_error(report.before.model, run), run_error(report.after.model, run), run.unit)
        for run in split.runs
    )
    before, after = (e.derivative_error[case.state] for e in (report.before, report.after))
    derivative = (before, after)
    effects = tuple(effect.name for effect in report.effects)
    reached = {
        "names": case.named(set(effects)),
        "derivative": derivative[1] <= case.derivative_limit,
        "free run": all(
            after <= run.limit for run, (_, after, _) in zip(split.runs, runs, strict=True)
        ),
    }
    if case.drag is not None:
        expected = -case.drag(folder)
        reached["drag"] = any(abs(k / expected - 1.0) <= 0.3 for k in drags(report))
    return Result(
        report.verdict, effects, derivative, runs, reached, seconds, peak_memory(), str(report)
    )


def drags(report: pse.LoopReport) -> list[float]:
    """Return the coefficients of quadratic drag, as an effect or as an alternative."""
    options = [one for effect in report.effects for one in (effect, *effect.rivals)]
    return [float(one.coefficients[0]) for one in options if one.name == "quadratic drag"]


def in_new_process(name: str, folder=None, seed: int = 0) -> Result:
    # One that is spawned begins with the peak memory of this one.
    pool = multiprocessing.get_context("forkserver").Pool(1)
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
        (CASES | OPEN)[name].target,
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
    known = CASES | OPEN
    names += [n for n in OPEN if n.split()[0] in given.case]
    names += [n for n in given.case if n in known and n not in names]
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
