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
import time
import zlib
from collections import defaultdict
from dataclasses import dataclass
from functools import cache

import numpy as np
import sympy
from joblib import Parallel, delayed
from scipy.signal import lfilter
from scipy.stats import beta
from tqdm import tqdm

import pysindy_evolve as pse

SUBSTEPS = 2  # of the integration, a sample


@dataclass(frozen=True)
class System:
    """A machine: declared equations with true parameters, and where the effect enters."""

    equations: dict
    parameters: dict
    order: int  # states of each measured column
    state: str  # whose equation the effect enters
    position: str  # called q in the effects below
    dt: float
    band: tuple  # lowest and highest frequency of the input
    start: tuple
    force: str  # RMS of this is what effects are measured by
    shaken: str = "1"  # what process noise multiplies

    @property
    def measured(self) -> list[int]:
        return list(range(0, len(self.equations), self.order))


SYSTEMS = {
    "oscillator": System(
        {"q": "v", "v": "-k*q - c*v + b*u"},
        {"k": 40.0, "c": 0.8, "b": 10.0},
        2, "v", "q", 0.015, (0.1, 1.6), (0.0, 0.0), "b*u",
    ),
    "duffing": System(
        {"q": "v", "v": "-k*q - e*q**3 - c*v + b*u"},
        {"k": 10.0, "e": 60.0, "c": 0.5, "b": 6.0},
        2, "v", "q", 0.02, (0.1, 1.2), (0.1, 0.0), "b*u",
    ),
    "pendulum": System(
        {"q": "v", "v": "-g*sin(q) - c*v + b*u"},
        {"g": 20.0, "c": 0.6, "b": 2.5},
        2, "v", "q", 0.02, (0.1, 1.2), (0.5, 0.0), "b*u",
    ),
    "rolling mass": System(
        {"q": "v", "v": "-c*v + b*u"},
        {"c": 0.6, "b": 4.0},
        2, "v", "q", 0.02, (0.1, 1.0), (0.0, 0.0), "b*u",
    ),
    "two masses": System(
        {"p": "w", "w": "-k*p - c*w + s*(q - p) + b*u", "q": "v", "v": "-r*(q - p) - d*v"},
        {"k": 30.0, "c": 0.6, "s": 20.0, "b": 10.0, "r": 25.0, "d": 0.5},
        2, "v", "q", 0.015, (0.1, 1.6), (0.0, 0.0, 0.0, 0.0), "r*(q - p)",
    ),
    "circuit": System(
        {"v": "-a*v + b*u"},
        {"a": 1.5, "b": 3.0},
        1, "v", "v", 0.02, (0.02, 0.8), (0.0,), "b*u",
    ),
    "population": System(
        {"v": "a*v - f*v**2 - b*v*w + h*u*v", "w": "-c*w + d*v*w"},
        {"a": 2.0, "f": 0.2, "b": 0.8, "h": 0.5, "c": 1.2, "d": 0.6},
        1, "v", "v", 0.04, (0.05, 0.4), (2.0, 1.5), "b*v*w", "v/5",
    ),
}  # fmt: skip

# Q, V, U: RMS of position, speed and input on the nominal path; L: length of the record.
MECHANICAL = {
    "Coulomb": ("sgn(v)", {"Coulomb friction"}),
    "Stribeck": ("sgn(v)*(1 + 2*exp(-(v/(0.3*V))**2))", {"Coulomb friction", "Stribeck friction"}),
    "drag": ("v*abs(v)", {"quadratic drag"}),
    "v^3": ("v**3", {"nonlinear damping"}),
    "offset": ("1", {"constant offset"}),
    "q^2": ("q**2", {"quadratic stiffness", "constant offset", "gravity"}),
    "q^3": ("q**3", {"cubic stiffness", "gravity"}),
    "dead zone": ("q - clip(q, 0.5*Q)", {"dead zone"}),
    "|q|sgn(v)": ("abs(q)*sgn(v)", {"position-dependent friction"}),
    "q^2 v": ("q**2*v", {"nonlinear damping"}),
    "u|u|": ("u*abs(u)", {"input nonlinearity"}),
    "saturation": ("clip(u, 0.8*U) - u", {"saturation"}),
    "forcing": ("sin(2.3*t)", {"periodic forcing"}),
    "drift": ("t/L", {"drift", "constant offset"}),
    "*v cos(q)": ("v*cos(2*q/Q)", None),
    "*tanh(q)": ("tanh(q/(0.3*Q))", None),
    "*q|v|": ("q*abs(v)", None),
    "*sqrt|v|": ("sqrt(abs(v))*sgn(v)", None),
    "*q|q|": ("q*abs(q)", None),
    "*exp(q)": ("exp(q/Q)", None),
}
ON_SPEED = ("Coulomb", "Stribeck", "drag", "v^3", "offset", "u|u|", "saturation", "*sqrt|v|")
ROLLING = {name: MECHANICAL[name] for name in (*ON_SPEED, "forcing", "drift")}
FIRST_ORDER = {
    "offset": ("1", {"constant offset"}),
    "square": ("v*abs(v)", {"quadratic drag"}),
    "cube": ("v**3", {"nonlinear damping"}),
    "u|u|": ("u*abs(u)", {"input nonlinearity"}),
    "forcing": ("sin(2.3*t)", {"periodic forcing"}),
    "*v/(c+v)": ("v/(V + abs(v))", None),
    "*sqrt": ("sqrt(abs(v))*sgn(v)", None),
    "*tanh": ("tanh(v/(0.3*V))", None),
    "*exp": ("exp(v/V)", None),
}
POPULATION = {
    "offset": ("1", {"constant offset"}),
    "cube": ("v**3", {"nonlinear damping"}),
    "w": ("w", {"coupling"}),
    "w^2": ("w**2", {"coupling"}),
    "u": ("u", {"input gain"}),
    "forcing": ("sin(2.3*t)", {"periodic forcing"}),
    "*v/(c+v)": ("v/(V + v)", None),
    "*vw/(c+v)": ("v*w/(V + v)", None),
    "*sqrt": ("sqrt(v)", None),
}
NULLS = (
    "white 0.1 %", "white 0.5 %", "white 2 %", "no noise", "colored", "over-smoothed",
    "closed-loop", "standstill", "quantized", "process noise", "slow process noise", "short",
    "records", "noisy input",
)  # fmt: skip


def effects_of(system: System) -> dict:
    right_hand_side = system.equations[system.state]
    if system.order == 2:
        known = {"q^3"} if "q**3" in right_hand_side else set()
        table = MECHANICAL if "q" in right_hand_side else ROLLING
        return {name: effect for name, effect in table.items() if name not in known}
    return POPULATION if "w" in system.equations else FIRST_ORDER


@cache
def right_hand_side(name: str, effect: str = "0"):
    """Compile f(x, u, t, disturbance) from the text of the equations."""
    system = SYSTEMS[name]
    local = {"sgn": sympy.sign, "abs": sympy.Abs}
    local["clip"] = lambda x, e: (sympy.Abs(x + e) - sympy.Abs(x - e)) / 2
    names = [*system.equations, "u", "t", "disturbance"]
    local |= {n: sympy.Symbol(n, real=True) for n in names}
    sides = []
    for state, text in system.equations.items():
        side = sympy.sympify(text, locals=local | system.parameters)
        if state == system.state:
            q = local[system.position]
            side += sympy.sympify(effect, locals=local | {"q": q})
            side += local["disturbance"] * sympy.sympify(system.shaken, locals=local)
        sides.append(side)
    sign = {"sign": lambda x: (x > 0) - (x < 0)}
    return sympy.lambdify([local[n] for n in names], sides, modules=[sign, "math"])


def ahead(x, rate, h):
    return [p + h * r for p, r in zip(x, rate, strict=True)]


def simulate(f, start, t, u, disturbance):
    """Runge-Kutta with u as a function of sample number and state, or an array on half substeps."""
    h = (t[1] - t[0]) / SUBSTEPS
    x, path, applied = list(start), [], []
    for i in range(len(t)):
        path.append(x)
        held = u(i, x) if callable(u) else None
        applied.append(u[2 * SUBSTEPS * i] if held is None else held)
        for s in range(SUBSTEPS):
            j, now = 2 * (SUBSTEPS * i + s), t[i] + s * h
            inputs = (u[j], u[j + 1], u[j + 2]) if held is None else (held,) * 3
            d = disturbance[i]
            a = f(*x, inputs[0], now, d)
            b = f(*ahead(x, a, h / 2), inputs[1], now + h / 2, d)
            c = f(*ahead(x, b, h / 2), inputs[1], now + h / 2, d)
            e = f(*ahead(x, c, h), inputs[2], now + h, d)
            for rate, weight in ((a, 1), (b, 2), (c, 2), (e, 1)):
                x = ahead(x, rate, weight * h / 6)
    return np.array(path), np.array(applied)


def multisine(t, band, rng):
    frequencies = np.geomspace(*band, 15) * rng.uniform(0.95, 1.05, 15)
    phases = rng.uniform(0, 2 * np.pi, 15)
    return sum(
        np.cos(2 * np.pi * f * t + p) for f, p in zip(frequencies, phases, strict=True)
    ) / np.sqrt(7.5)


def fine(t):
    """Times of all half substeps, one sample beyond the end."""
    return t[0] + np.arange(2 * SUBSTEPS * (len(t) + 1)) * (t[1] - t[0]) / (2 * SUBSTEPS)


@cache
def sizes(name: str, n: int) -> dict:
    """RMS of position, speed, input and force where nothing is missing."""
    system = SYSTEMS[name]
    t = np.arange(n) * system.dt
    u = multisine(fine(t), system.band, np.random.default_rng(7))
    x, applied = simulate(right_hand_side(name), system.start, t, u, np.zeros(n))
    rms = dict(zip(system.equations, np.sqrt(np.mean(x**2, axis=0)), strict=True))
    values = dict(zip(system.equations, x.T, strict=True)) | {"u": applied} | system.parameters
    force = sympy.lambdify(list(values), sympy.sympify(system.force, locals=symbols(values)))
    size = float(np.sqrt(np.mean(np.broadcast_to(force(**values), n) ** 2)))
    scale = {"Q": rms[system.position], "V": rms[system.state], "U": applied.std(), "L": t[-1]}
    return {
        "scale": scale,
        "force": size,
        "values": values | {"t": t, "q": values[system.position]},
    }


def symbols(names):
    return {n: sympy.Symbol(n, real=True) for n in names}


def scaled_effect(name: str, effect: str, share: float, n: int) -> tuple[str, str]:
    """Return the effect with its coefficient, and without it, as text with numbers."""
    system, size = SYSTEMS[name], sizes(name, n)
    text = effects_of(system)[effect][0]
    for symbol, value in size["scale"].items():
        text = text.replace(symbol, f"{value:.6g}")
    tools = {"sgn": np.sign, "abs": np.abs, "clip": lambda x, e: np.clip(x, -e, e)}
    tools |= {k: getattr(np, k) for k in ("exp", "sin", "cos", "tanh", "sqrt")}
    rms = np.sqrt(np.mean(np.square(eval(text, {}, tools | size["values"]))))  # noqa: S307
    # Away from equilibrium a growth term would only make a population explode.
    return f"-({share * size['force'] / rms:.8g})*({text})", text


def generator(seed, *case):
    """Return a generator of its own for each case: shared noise would be counted many times."""
    return np.random.default_rng([seed, zlib.crc32(" ".join(case).encode())])


def ar1(n, memory, rng):
    white = rng.standard_normal(n + 200)
    return lfilter([np.sqrt(1 - memory**2)], [1, -memory], white)[200:]


def measure(name, n, kind, rng, effect="0", percent=0.5):
    """Simulate one record and prepare it."""
    system = SYSTEMS[name]
    t = np.arange(n) * system.dt
    u = multisine(fine(t), system.band, rng)
    disturbance = np.zeros(n)
    if kind == "standstill":
        u = u * (np.sin(2 * np.pi * fine(t) / (n * system.dt / 3)) > -0.2)
    if kind in ("process noise", "slow process noise"):
        memory = 0.9 if kind == "process noise" else 0.99
        disturbance = 0.05 * sizes(name, n)["force"] * ar1(n, memory, rng)
    f = right_hand_side(name, effect)
    if kind == "closed-loop":
        x, u_seen, noise = closed_loop(name, f, t, u, percent, rng)
    else:
        x, u_seen = simulate(f, system.start, t, u, disturbance)
        noise = None
    y = x[:, system.measured]
    spread = y.std(axis=0)
    if kind == "quantized":
        y = np.round(y / (0.03 * spread)) * 0.03 * spread
    elif kind == "colored":
        y = y + 0.01 * spread * np.column_stack([ar1(n, 0.9, rng) for _ in spread])
    elif kind != "no noise":
        white = rng.standard_normal(y.shape) if noise is None else noise
        y = y + percent / 100 * spread * white
    if kind == "noisy input":
        u_seen = u_seen + 0.02 * u_seen.std() * rng.standard_normal(n)
    record = pse.prepare(t, y, u_seen, order=system.order)
    if kind == "over-smoothed":
        record = pse.prepare(t, y, u_seen, order=system.order, cutoff=record.preparation.cutoff / 2)
    return record


def closed_loop(name, f, t, reference, percent, rng):
    """Let a discrete PD controller act on the noisy measurement; u is seen as its mean at t."""
    system, size = SYSTEMS[name], sizes(name, len(t))
    column = list(system.equations).index(system.position)
    white = rng.standard_normal((len(t), len(system.measured)))
    sigma = percent / 100 * size["scale"]["Q"]
    memory = {"y": 0.0, "d": 0.0}

    def control(i, x):
        y = x[column] + sigma * white[i, system.measured.index(column)]
        memory["d"] += 0.2 * ((y - memory["y"]) / system.dt - memory["d"])
        memory["y"] = y
        r = reference[2 * SUBSTEPS * i]
        return r - 0.5 * (y / size["scale"]["Q"]) - 0.2 * memory["d"] / size["scale"]["V"]

    x, held = simulate(f, system.start, t, control, np.zeros(len(t)))
    return (
        x,
        (held + np.append(held[0], held[:-1])) / 2,
        white * size["scale"]["Q"] / x[:, system.measured].std(axis=0),
    )


def declare(name, extra=""):
    system = SYSTEMS[name]
    sides = dict(system.equations)
    sides[system.state] += extra
    return pse.DeclaredModel(sides, inputs=["u"])


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
    known = loop(
        declare(name, f" + eff*({clipped(bare)})"), [record], seed, options | {"max_effects": 0}
    )
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
        "names": [e.name for e in report.effects],
        "terms": [f"{e.state}: {e.term}" for e in report.effects],
        "p": [e.p_value for e in report.effects],
        "alternatives": [list(e.alternatives) for e in report.effects],
    }


def interval(k, n):
    """Return the 95 % Clopper-Pearson interval of a rate, percent."""
    low = 0.0 if k == 0 else beta.ppf(0.025, k, n - k + 1)
    high = 1.0 if k == n else beta.ppf(0.975, k + 1, n - k)
    return 100 * low, 100 * high


def grouped(rows, key):
    groups = defaultdict(list)
    for r in rows:
        groups[key(r)].append(r)
    return groups


def print_nulls(rows):
    print(f"\n{'nothing missing':<20}{'runs':>6}{'named':>7}{'rate %':>8}{'95 %':>14}   names")
    by_system = grouped(rows, lambda r: "  " + r["system"])
    for kind, group in {**grouped(rows, lambda r: r["kind"]), **by_system, "all": rows}.items():
        k, n = sum(bool(r["names"]) for r in group), len(group)
        low, high = interval(k, n)
        names = defaultdict(int)
        for r in group:
            for name in r["names"][:1]:
                names[name] += 1
        shown = ", ".join(f"{v} {k}" for k, v in sorted(names.items(), key=lambda x: -x[1]))
        print(f"{kind:<20}{n:>6}{k:>7}{100 * k / n:>8.1f}{low:>6.1f} -{high:>5.1f}    {shown}")
    print(f"median seconds a loop: {np.median([r['seconds'] for r in rows]):.2f}")


def judged(r):
    """Return whether anything, the right first, the right at all was named, and the extras."""
    right = effects_of(SYSTEMS[r["system"]])[r["effect"]][1]
    if right is None:
        return bool(r["names"]), np.nan, np.nan, max(0, len(r["names"]) - 1)
    first = bool(r["names"]) and bool(right & {r["names"][0], *r["alternatives"][0]})
    hits = [bool(right & {n, *a}) for n, a in zip(r["names"], r["alternatives"], strict=True)]
    return bool(r["names"]), float(first), float(any(hits)), len(hits) - sum(hits)


def print_effects(rows):
    keys = (
        lambda r: (f"{100 * r['share']:g} %", f"noise {r['percent']:g} %"),
        lambda r: (r["effect"], f"{100 * r['share']:g} %"),
        lambda r: (r["system"], f"{100 * r['share']:g} %"),
    )
    for key in keys:
        print(
            f"\n{'':<28}{'runs':>5}{'named':>7}{'first':>7}{'found':>7}{'extra':>7}{'free<=1.2':>11}"
        )
        for label, group in sorted(grouped(rows, key).items()):
            scores = np.array([judged(r) for r in group], dtype=float)
            known = scores[~np.isnan(scores[:, 1])]
            first, found = known[:, 1:3].mean(axis=0) if len(known) else (np.nan, np.nan)
            ratio = np.array([r["free_run"][1] / r["free_run"][2] for r in group])
            print(
                f"{' '.join(label):<28}{len(group):>5}{scores[:, 0].mean():>7.2f}{first:>7.2f}"
                f"{found:>7.2f}{scores[:, 3].mean():>7.2f}{(ratio <= 1.2).mean():>11.2f}"
            )
    print(f"median seconds a loop: {np.median([r['seconds'] for r in rows]):.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--null", type=int, default=0, help="runs of each null kind and system")
    parser.add_argument("--effects", type=int, default=0, help="runs of each effect and noise")
    parser.add_argument("--systems", nargs="+", default=list(SYSTEMS), choices=SYSTEMS)
    parser.add_argument("--kinds", nargs="+", default=list(NULLS), choices=NULLS)
    parser.add_argument("--only", nargs="+", help="names of effects")
    parser.add_argument("--shares", nargs="+", type=float, default=[0.02, 0.05])
    parser.add_argument("--noise", nargs="+", type=float, default=[0.1, 0.5, 2.0], help="percent")
    parser.add_argument("--n", type=int, default=6000, help="raw samples")
    parser.add_argument("--n-twins", type=int, default=39)
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
