"""
Reading the report
==================

A slow record shows that damping is missing, but not which: v|v| and v³ look alike at low speed, and
here the wrong one comes out a little better. The report says so, says what to measure next, and
shows where the residual lives.
"""

# %%
# A driven oscillator with drag, moved slowly, its position measured with noise. The declared model
# knows only viscous damping.

import numpy as np

import pysindy_evolve as pse

rng = np.random.default_rng(0)
t = np.arange(0.0, 40.0, 0.01)
frequencies = np.linspace(0.1, 2.5, 30)
phases = rng.uniform(0.0, 2.0 * np.pi, 30)


def measure(size):
    """Return a record of the machine, driven by a multisine of this size."""
    F = size * np.sin(2.0 * np.pi * np.outer(t, frequencies) + phases).sum(axis=1) / np.sqrt(15.0)
    machine = pse.DeclaredModel({"q": "v", "v": "-40*q - 0.8*v - 0.5*v*abs(v) + F"}, inputs=["F"])
    q = pse.simulate(machine.design().equations([]), [0.0, 0.0], t, F[:, None])[:, 0]
    return pse.prepare(t, q + 4e-4 * rng.standard_normal(t.size), F)


declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
report = pse.close_loop(declared, measure(0.5), operators=(), random_state=0)
print(report)

# %%
# What to measure next, in the units of the rig.

units = {"q": "m", "v": "m/s", "F": "N", "t": "s"}
print(report.suggest_experiment(units))

# %%
# Where the residual lives. ``report.to_html("report.html", units)`` holds this picture, the twins
# of each effect and everything that was printed, on one page.

report.plot(units=units)

# %%
# A record of the proposed motion settles it.

far = report.suggest_experiment().experiments[0].motion.amplitude
train, test = [measure(0.5), measure(0.5 * far)], measure(0.5 * far)
again = pse.close_loop(declared, train, test, operators=(), random_state=0)
for effect in again.effects:
    print(effect.name, "or", ", ".join(effect.alternatives) or "nothing else")
