"""Simulation by a Runge-Kutta scheme of its own, and the sizes that effects are measured by."""

from functools import cache

import numpy as np
import sympy

from .effects import effects_of
from .systems import SYSTEMS

SUBSTEPS = 2  # of the integration, a sample


@cache
def right_hand_side(name: str, effect: str = "0"):
    """Compile f(x, u, t, disturbance) from the text of the equations.

    What an effect remembers of the motion is one more state.
    """
    system = SYSTEMS[name]
    local = {"sgn": sympy.sign, "abs": sympy.Abs}
    local["clip"] = lambda x, e: (sympy.Abs(x + e) - sympy.Abs(x - e)) / 2
    names = [*system.equations, *hidden_states(effect), "u", "t", "disturbance"]
    local |= {n: sympy.Symbol(n, real=True) for n in names}
    sides, rates = [], []

    def bouc_wen(q, v, length, unloading):
        rates.append(yield_rate(v, local["yielded"], length, unloading))
        return local["yielded"]

    local["bouc_wen"] = bouc_wen
    for state, text in system.equations.items():
        side = sympy.sympify(text, locals=local | system.parameters)
        if state == system.state:
            q = local[system.position]
            side += sympy.sympify(effect, locals=local | {"q": q})
            side += local["disturbance"] * sympy.sympify(system.shaken, locals=local)
        sides.append(side)
    sign = {"sign": lambda x: (x > 0) - (x < 0)}
    return sympy.lambdify([local[n] for n in names], sides + rates, modules=[sign, "math"])


def hidden_states(effect):
    return ["yielded"] if "bouc_wen(" in effect else []


def yield_rate(v, w, length, unloading):
    """Bouc and Wen's w', of a unit yield force."""
    held = (1 + unloading) / 2 * abs(v) * w + (1 - unloading) / 2 * v * abs(w)
    return (v - held) / length


def along(q, v, length, unloading):
    """Go along a path in small steps: how strong a hysteresis is there."""
    w, path = 0.0, []
    for step in np.diff(q, prepend=q[0]):
        for _ in range(10):
            w += yield_rate(step / 10, w, length, unloading)
        path.append(w)
    return np.array(path)


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


def nominal_lines(band):
    return np.geomspace(*band, 15)


def multisine(t, band, rng):
    frequencies = nominal_lines(band) * rng.uniform(0.95, 1.05, 15)
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
    lines = nominal_lines(system.band)
    between = np.sqrt(lines[1:] * lines[:-1])
    scale["W"] = 2 * np.pi * between[np.argmin(np.abs(between - 0.37))]
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
    tools["bouc_wen"] = along
    tools |= {k: getattr(np, k) for k in ("exp", "sin", "cos", "tanh", "sqrt")}
    rms = np.sqrt(np.mean(np.square(eval(text, {}, tools | size["values"]))))  # noqa: S307
    # Away from equilibrium a growth term would only make a population explode.
    return f"-({share * size['force'] / rms:.8g})*({text})", text
