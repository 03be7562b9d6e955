"""The Bouc-Wen benchmark, simulated with its numbers: `python benchmarks/bouc_wen.py`.

A mass of 2 kg on a joint that dissipates in a hysteresis, driven by a multisine from 5 to 150 Hz
with 50 N RMS; the displacement is read with 8 um of noise at 750 Hz, 1.2 % of its standard
deviation. Declared are mass, damper and spring. One period to fit, another multisine to judge by.
Noel, Schoukens, "Hysteretic benchmark with a dynamic nonlinearity" (2016), nonlinearbenchmark.org.
"""

import argparse

import numpy as np
from scipy.signal import resample

import pysindy_evolve as pse

MASS, DAMPING, STIFFNESS = 2.0, 10.0, 5e4
ALPHA, BETA, GAMMA, DELTA = 5e4, 1e3, 0.8, -1.1  # z' = alpha v - beta (gamma |v| z + delta v |z|)
RATE, LINES, RMS, NOISE = 750.0, (5.0, 150.0), 50.0, 8e-6  # Hz, Hz, N, m
FINER = 20  # steps of the integration from one sample to the next


def multisine(n, rng):
    """Draw one period of a force."""
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    lines = (frequency >= LINES[0]) & (frequency <= LINES[1])
    force = np.fft.irfft(lines * np.exp(2j * np.pi * rng.uniform(size=len(lines))), n)
    return RMS * force / force.std()


def rates(x, force):
    y, v, z = x
    dissipated = GAMMA * abs(v) * z + DELTA * v * abs(z)
    return np.array(
        [v, (force - STIFFNESS * y - DAMPING * v - z) / MASS, ALPHA * v - BETA * dissipated]
    )


def displacement(force):
    """Return the steady response to a force that comes again (Runge and Kutta, fourth order)."""
    fine, h = resample(np.tile(force, 2), 2 * FINER * len(force)), 1.0 / (RATE * FINER)
    x, found = np.zeros(3), np.empty((len(fine), 3))
    for i, (now, then) in enumerate(zip(fine, np.roll(fine, -1), strict=True)):
        found[i], between = x, 0.5 * (now + then)
        a = rates(x, now)
        b = rates(x + 0.5 * h * a, between)
        c = rates(x + 0.5 * h * b, between)
        x = x + h / 6.0 * (a + 2.0 * b + 2.0 * c + rates(x + h * c, then))
    return found[len(fine) // 2 :: FINER, 0]


def record(n, rng):
    force = multisine(n, rng)
    y = displacement(force) + NOISE * rng.standard_normal(n)
    return pse.prepare(np.arange(n) / RATE, y, force)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=4096, help="samples of a period")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    declared = pse.DeclaredModel({"y": "v", "v": "b*u - c*v - k*y"}, inputs=["u"])
    print(pse.close_loop(declared, *(record(given.n, rng) for _ in range(2)), random_state=0))


if __name__ == "__main__":
    main()
