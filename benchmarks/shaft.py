"""A motor that turns a load by an elastic shaft: `python benchmarks/shaft.py`.

Both angles are measured, and their difference, the twist, is a few times as large as the noise.
Nothing is missing, or the load has a dry friction. Printed are the verdict, what was named, and the
stiffness of the shaft over the inertia of motor and load, fitted over true.
"""

import argparse

import numpy as np
from scipy.integrate import solve_ivp

import pysindy_evolve as pse

MOTOR, LOAD = 0.2, 0.3  # inertia, kg m^2
STIFFNESS, DAMPING, BEARINGS = 400.0, 0.4, (0.3, 0.2)  # Nm/rad, Nm s/rad
DT, DURATION, LINES = 0.004, 40.0, (0.1, 6.0)  # s, s, Hz
SIDES = {
    "p": "w",
    "w": "b*u - c*w - k*(p - q) - d*(w - v)",
    "q": "v",
    "v": "r*(p - q) + s*(w - v) - e*v",
}


def torque(rng):
    """Draw forty sines of equal amplitude, Nm."""
    frequencies = np.linspace(*LINES, 40) + rng.uniform(-0.02, 0.02, 40)
    phases = rng.uniform(0.0, 2.0 * np.pi, 40)

    def at(t):
        waves = np.sin(2.0 * np.pi * np.multiply.outer(t, frequencies) + phases)
        return 3.0 * waves.sum(axis=-1) / np.sqrt(20.0)

    return at


def records(twist_over_noise, friction, rng):
    """Return the record to fit and the one to judge by."""
    t, drive = np.arange(0.0, DURATION, DT), torque(rng)

    def rates(time, x):
        p, w, q, v = x
        inside = STIFFNESS * (p - q) + DAMPING * (w - v)
        dry = friction * np.tanh(v / 1e-3)
        load = (inside - BEARINGS[1] * v - dry) / LOAD
        return w, (drive(time) - BEARINGS[0] * w - inside) / MOTOR, v, load

    run = solve_ivp(rates, (0.0, t[-1]), [0.0] * 4, "LSODA", t, rtol=1e-8, atol=1e-10)
    y = run.y[::2].T
    noise = np.std(y[:, 0] - y[:, 1]) / twist_over_noise
    y, u = y + noise * rng.standard_normal(y.shape), drive(t)
    cut = int(0.7 * len(t))
    return [pse.prepare(t[part], y[part], u[part]) for part in (slice(cut), slice(cut, None))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ratios", nargs="+", type=float, default=[10.0, 5.0, 3.0, 1.5])
    parser.add_argument("--frictions", nargs="+", type=float, default=[0.0, 0.3], help="Nm")
    parser.add_argument("--seeds", type=int, default=4)
    given = parser.parse_args()
    declared = pse.DeclaredModel(SIDES, inputs=["u"])
    true = {"k": STIFFNESS / MOTOR, "r": STIFFNESS / LOAD}
    print("twist / noise, friction Nm, seed: verdict, named, k and r over the true ones")
    for ratio in given.ratios:
        for friction in given.frictions:
            for seed in range(given.seeds):
                fit, judge = records(ratio, friction, np.random.default_rng(seed))
                report = pse.close_loop(declared, fit, judge, random_state=0)
                found = report.after.parameters
                print(
                    f"{ratio:g}, {friction:g}, {seed}: {report.verdict},",
                    [f"{e.name} in {e.state}'" for e in report.effects],
                    *(f"{name} {found[name] / value:.3f}" for name, value in true.items()),
                    flush=True,
                )


if __name__ == "__main__":
    main()
