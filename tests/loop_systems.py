"""Simulated machines of which the truth is known, for the tests of the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

import pysindy_evolve as pse
from pysindy_evolve.equations import Equations

DT = 0.01


def equations_of(sides: Mapping[str, str], inputs: tuple[str, ...] = ()) -> Equations:
    """Return equations written as text with all numbers in it."""
    return pse.DeclaredModel(sides, inputs=inputs).design().equations([])


def multisine(
    size: float, seed: int, band: tuple[float, float] = (0.1, 2.5)
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a force of 30 sines of equal amplitude and random phase as a function of time."""
    rng = np.random.default_rng(seed)
    frequencies = np.linspace(*band, 30) + rng.uniform(-0.02, 0.02, 30)
    phases = rng.uniform(0.0, 2 * np.pi, 30)

    def force(t: np.ndarray) -> np.ndarray:
        waves = np.sin(2 * np.pi * np.outer(t, frequencies) + phases)
        return size * waves.sum(axis=1) / np.sqrt(15.0)

    return force


def measured(
    sides: Mapping[str, str],
    *,
    noise: float = 1e-3,
    duration: float = 40.0,
    size: float = 20.0,
    seed: int = 0,
    x0: tuple[float, ...] = (),
    order: int = 2,
) -> pse.Record:
    """Simulate a machine driven by F, put noise on its positions, and prepare the record.

    `noise` is the share of the standard deviation of each position.
    """
    model = equations_of(sides, ("F",))
    t, force = np.arange(0.0, duration, DT), multisine(size, seed)
    # As a function: a force that is linear between samples would be another force.
    x = pse.simulate(model, list(x0) or [0.0] * len(sides), t, force, tolerance=1e-8)
    y = x[:, ::order]
    rng = np.random.default_rng(seed + 1000)
    y = y + noise * y.std(axis=0) * rng.standard_normal(y.shape)
    return pse.prepare(t, y, force(t), order=order)


@dataclass(frozen=True)
class Hidden:
    """A machine, its declared model, and the effect that the declared model lacks."""

    effect: str
    truth: Mapping[str, str]
    declared: Mapping[str, str]
    state: str = "v"
    options: Mapping[str, object] = field(default_factory=dict)

    def record(self, **options) -> pse.Record:
        return measured(self.truth, **{**self.options, **options})

    @property
    def model(self) -> pse.DeclaredModel:
        return pse.DeclaredModel(self.declared, inputs=["F"])


def oscillator(effect: str, term: str, declared: str = "-k*q - c*v + b*F", **options) -> Hidden:
    """Return a driven oscillator with one more term."""
    truth = {"q": "v", "v": f"-40*q - 0.8*v + F {term}"}
    return Hidden(effect, truth, {"q": "v", "v": declared}, options=options)


def hidden_effects() -> list[Hidden]:
    """Return one machine for each static or time-dependent effect of the vocabulary."""
    two = {"q1": "v1", "v1": "-40*q1 - 0.8*v1 + F", "q2": "v2", "v2": "-90*q2 - 1.1*v2 + 20*q1"}
    apart = {"q1": "v1", "v1": "-k*q1 - c*v1 + b*F", "q2": "v2", "v2": "-m*q2 - d*v2"}
    driven = {"q1": "v1", "v1": "-40*q1 - 0.8*v1 + F", "q2": "v2"}  # q2 feels q1, not the reverse
    linear = {**apart, "v2": "-k2*(q2 - q1) - d*(v2 - v1)"}
    rubbed = "-k*q - c*v + b*F - f*sgn(v)"
    return [
        oscillator("Coulomb friction", "- 2*sgn(v)"),
        oscillator(
            "asymmetric Coulomb friction",
            "- 2*sgn(v) + 0.3 - 0.6*abs(v)",
            rubbed + " + o",
        ),
        oscillator("Stribeck friction", "- 2*sgn(v) - 4*sgn(v)*exp(-(v/2)^2)", rubbed),
        oscillator("position-dependent friction", "- 3*q^2*sgn(v)"),
        oscillator("viscous damping", "", "-k*q + b*F"),
        oscillator("quadratic drag", "- 0.5*v*abs(v)"),
        oscillator("nonlinear damping", "- 8*q^2*v"),
        oscillator("linear stiffness", "", "-c*v + b*F"),
        oscillator("quadratic stiffness", "- 12*q^2", "-k*q - c*v + b*F + o", size=6.0),
        oscillator("cubic stiffness", "- 40*q^3"),
        oscillator("quintic stiffness", "- 60*q^5"),
        oscillator("dead zone", "+ 40*0.5*(abs(q + 0.2) - abs(q - 0.2))"),
        oscillator("saturation", "- F + 0.5*(abs(F + 29) - abs(F - 29))"),
        Hidden(
            "gravity",
            {"q": "v", "v": "-30*sin(q) - 0.8*v + F"},
            {"q": "v", "v": "-c*v + b*F"},
            options={"size": 40.0},
        ),
        oscillator("constant offset", "+ 1.5"),
        Hidden("coupling", two, apart, "v2"),
        Hidden(
            "nonlinear damping",  # a damper that is stiffer in rebound
            {**driven, "v2": "-90*(q2 - q1) - 3*(v2 - v1) - 2*abs(v2 - v1)"},
            {**linear, "v2": linear["v2"] + " + o"},
            "v2",
        ),
        Hidden(
            "dead zone",  # backlash
            {
                **driven,
                "v2": "-90*(q2 - q1) - 3*(v2 - v1) + 45*(abs(q2 - q1 + 0.1) - abs(q2 - q1 - 0.1))",
            },
            linear,
            "v2",
        ),
        oscillator("input nonlinearity", "- 0.0004*F^3"),
        oscillator("input gain", "", "-k*q - c*v"),
        oscillator("drift", "+ 0.1*t", "-k*q - c*v + b*F + o"),
        oscillator("periodic forcing", "+ 2*sin(21.3*t + 0.4)"),
        Hidden(
            "position-periodic ripple",
            {"q": "v", "v": "-2*v + F + 1.5*sin(12*q + 0.4)"},
            {"q": "v", "v": "-c*v + b*F"},
            options={"size": 8.0},
        ),
    ]


def levitated(seed: int, *, held: bool = False, n: int = 20_000) -> pse.Record:
    """Simulate a magnet that a current holds, controlled by what a noisy sensor shows.

    The current is straight between samples, or held from each one to the next.
    """
    dt, noise = 1e-3, 2e-6
    rng = np.random.default_rng(seed)
    t = dt * np.arange(n)
    waves = np.sin(2 * np.pi * np.outer(t, np.linspace(0.2, 4.0, 25)) + rng.uniform(0, 6.3, 25))
    target = 0.01 + 6e-4 * waves.sum(axis=1) / waves.sum(axis=1).std()
    z, v, slope, before, current = 0.01, 0.0, 0.0, 0.01, 1.0
    shown, applied = np.empty(n), np.empty(n)
    for k in range(n):
        shown[k] = z + noise * rng.standard_normal()
        slope += 0.3 * ((shown[k] - before) / dt - slope)
        before = shown[k]
        after = min(max(1.0 + 250.0 * (before - target[k]) + 6.0 * slope, 0.1), 3.0)
        applied[k] = after if held else current
        for part in (0.125, 0.375, 0.625, 0.875):
            i = after if held else current + part * (after - current)
            middle = z + 0.125 * dt * v
            pull = 9.81 - 9.81e-4 * i**2 / middle**2
            z, v = z + 0.25 * dt * v + pull * dt**2 / 32.0, v + 0.25 * dt * pull
        current = after
    return pse.prepare(t, shown, applied)


def regulated(held: bool, n_steps: int) -> pse.Record:
    """Record a mass whose force answers the noise of its sensor at each sample."""
    dt, rng = 0.01, np.random.default_rng(2)
    wanted = np.repeat(rng.uniform(-0.3, 0.3, n_steps), 50)
    noise = 2e-3 * rng.standard_normal(len(wanted))
    (q, v), shown, slope, force = (0.0, 0.0), 0.0, 0.0, 0.0
    rows = []
    for r, e in zip(wanted, noise, strict=True):
        slope += 0.2 * ((q + e - shown) / dt - slope)
        before, shown = force, q + e
        force = 40.0 * (r - shown) - 9.0 * slope
        rows.append((shown, force if held else before))
        for part in (0.125, 0.375, 0.625, 0.875):
            acts = force if held else before + part * (force - before)
            middle = v + 0.125 * dt * (acts - 0.8 * v)
            q, v = q + 0.25 * dt * middle, v + 0.25 * dt * (acts - 0.8 * middle)
    y, u = np.array(rows).T
    return pse.prepare(dt * np.arange(len(y)), y, u)
