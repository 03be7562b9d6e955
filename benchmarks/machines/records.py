"""Records as a sensor gives them: noise, gaps, control loops and all that goes wrong."""

import zlib

import numpy as np
from scipy.signal import lfilter

import pysindy_evolve as pse

from .simulation import SUBSTEPS, fine, hidden_states, multisine, right_hand_side, simulate, sizes
from .systems import SYSTEMS

NULLS = (
    "white 0.1 %", "white 0.5 %", "white 2 %", "no noise", "colored", "over-smoothed",
    "closed-loop", "standstill", "quantized", "process noise", "slow process noise", "short",
    "records", "noisy input", "wandering sensor",
)  # fmt: skip


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
        start = (*system.start, *(0.0 for _ in hidden_states(effect)))
        x, u_seen = simulate(f, start, t, u, disturbance)
        noise = None
    y = x[:, system.measured]
    spread = y.std(axis=0)
    if kind == "quantized":
        y = np.round(y / (0.03 * spread)) * 0.03 * spread
    elif kind == "colored":
        y = y + 0.01 * spread * np.column_stack([ar1(n, 0.9, rng) for _ in spread])
    elif kind == "wandering sensor":
        walk = np.cumsum(rng.standard_normal(y.shape), axis=0) / np.sqrt(n)
        y = y + percent / 100 * spread * (rng.standard_normal(y.shape) + walk)
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
