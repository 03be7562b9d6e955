"""Does the loop name the effect that is missing, and nothing where nothing is missing?

    python benchmarks/undeclared.py --null 20            # runs for each null kind and system
    python benchmarks/undeclared.py --effects 2          # runs for each effect, size and noise
    python benchmarks/undeclared.py --null 1 --kinds closed-loop quantized --systems pendulum

Every machine is simulated by a Runge-Kutta scheme of its own, not by the package. The size of an
effect is its RMS over the RMS of the force (of the input in its equation, or of the whole rate
where no input enters it additively), before the declared terms absorb what they can of it.

In the null cases the declared model is the truth and only its parameters are free. The rate of
false naming comes with its 95 % Clopper-Pearson interval.
"""

import argparse
import json
import random
import time

from joblib import Parallel, delayed
from machines.effects import effects_of
from machines.records import NULLS, generator, measure
from machines.simulation import scaled_effect
from machines.systems import SYSTEMS
from tqdm import tqdm
from undeclared_tables import print_effects, print_nulls

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.boucwen import BOUC_WEN


def declare(name, extra=""):
    system = SYSTEMS[name]
    sides = dict(system.equations)
    sides[system.state] += extra
    return pse.DeclaredModel(sides, inputs=["u"], operators=[BOUC_WEN])


def run_null(name, kind, seed, options):
    rng = generator(seed, name, kind)
    percent = {"white 0.1 %": 0.1, "white 2 %": 2.0}.get(kind, 0.5)
    n = {"short": 500, "records": 2000}.get(kind, options["n"])
    copies = 4 if kind == "records" else 1
    records = [measure(name, n, kind, rng, percent=percent) for _ in range(copies)]
    begin = time.perf_counter()
    report = loop(declare(name), records, seed, options)
    seconds = time.perf_counter() - begin
    return row(report, system=name, kind=kind, seed=seed, seconds=seconds)


def run_effect(name, effect, share, percent, seed, options):
    rng = generator(seed, name, effect, str(share), str(percent))
    text, bare = scaled_effect(name, effect, share, options["n"])
    record = measure(name, options["n"], "white", rng, text, percent)
    begin = time.perf_counter()
    report = loop(declare(name), [record], seed, options)
    seconds = time.perf_counter() - begin
    # Of the model that lacks nothing only the free run is asked.
    known = loop(declare(name, f" + eff*({clipped(bare)})"), [record], seed, {"max_effects": 0})
    free = [float(r.simulation_error[0]) for r in (report.before, report.after, known.before)]
    found = row(report, system=name, effect=effect, share=share, percent=percent, seed=seed)
    return found | {"free_run": free, "seconds": seconds}


def clipped(text):
    """Write clip(x, e) with absolute values, for the declared model."""
    if "clip(" not in text:
        return text
    before, rest = text.split("clip(")
    inside, after = rest.split(")", 1)
    x, edge = (part.strip() for part in inside.split(","))
    return f"{before}(abs({x} + {edge}) - abs({x} - {edge}))/2{after}"


def loop(declared, records, seed, options):
    settings = {k: v for k, v in options.items() if k in ("n_twins", "max_effects")}
    return pse.close_loop(declared, records, random_state=seed, **settings)


def row(report, **case):
    return case | {
        "verdict": report.verdict,
        "names": [e.name for e in report.effects],
        "terms": [f"{e.state}: {e.term}" for e in report.effects],
        "p": [e.p_value for e in report.effects],
        "alternatives": [list(e.alternatives) for e in report.effects],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--null", type=int, default=0, help="runs of each null kind and system")
    parser.add_argument("--effects", type=int, default=0, help="runs of each effect and noise")
    parser.add_argument("--systems", nargs="+", default=list(SYSTEMS), choices=SYSTEMS)
    parser.add_argument("--kinds", nargs="+", default=list(NULLS), choices=NULLS)
    parser.add_argument("--only", nargs="+", help="names of effects")
    parser.add_argument("--shares", nargs="+", type=float, default=[0.02, 0.05])
    parser.add_argument("--noise", nargs="+", type=float, default=[0.1, 0.5, 2.0], help="percent")
    parser.add_argument(
        "--sample", type=int, help="draw at random so many of the runs with effects"
    )
    parser.add_argument("--n", type=int, default=6000, help="raw samples")
    parser.add_argument("--n-twins", type=int, default=299)
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    parser.add_argument("--n-jobs", type=int, default=1)
    parser.add_argument("--json", help="append all rows to this file, one a line")
    given = parser.parse_args()
    options = {"n": given.n, "n_twins": given.n_twins}
    seeds = range(given.seed, given.seed + max(given.null, given.effects))
    nulls = [
        delayed(run_null)(s, k, seed, options)
        for seed in seeds[: given.null] for k in given.kinds for s in given.systems
    ]  # fmt: skip
    effects = [
        delayed(run_effect)(s, e, share, percent, seed, options)
        for seed in seeds[: given.effects] for s in given.systems for e in effects_of(SYSTEMS[s])
        if given.only is None or e in given.only
        for share in given.shares for percent in given.noise
    ]  # fmt: skip
    if given.sample is not None:
        effects = random.Random(given.seed).sample(effects, min(given.sample, len(effects)))
    for calls, show in ((nulls, print_nulls), (effects, print_effects)):
        if calls:
            found = Parallel(n_jobs=given.n_jobs, return_as="generator")(calls)
            rows = []
            for r in tqdm(found, total=len(calls)):
                rows.append(r)
                if given.json:
                    with open(given.json, "a") as file:
                        file.write(json.dumps(r) + "\n")
            show(rows)


if __name__ == "__main__":
    main()
