"""
A fixed library against an evolved one
======================================

**Claim.** Where the truth lies in the fixed library, evolving it wins nothing. Where it does not,
the evolved library finds the terms, and its model holds beyond the motion it was fitted on.

Two free swings: a Duffing oscillator, whose cubic spring stands in PySINDy's polynomials, and a
pendulum with air drag, whose sine and ``v |v|`` do not. Both are fitted on one swing with noise of
30 dB on the acceleration, and judged on a free run from another start.
"""

import matplotlib.pyplot as plt
import numpy as np
import pysindy as ps
from scipy.integrate import solve_ivp

import pysindy_evolve as pse

SYSTEMS = {  # acceleration, start of the fit and of the held-out run
    "Duffing oscillator, q in m": (lambda q, v: -q - 0.1 * v - 2 * q**3, 2.0, -2.5),
    "Pendulum with air drag, q in rad": (
        lambda q, v: -9.81 * np.sin(q) - 0.1 * v * np.abs(v),
        2.0,
        -2.4,
    ),
}
t = np.arange(0.0, 20.0, 0.005)


def swing(acceleration, start):
    """Return q and v of a free swing from rest."""
    slope, span = lambda _, x: [x[1], acceleration(*x)], (0.0, t[-1])
    return solve_ivp(slope, span, [start, 0.0], t_eval=t, rtol=1e-9, atol=1e-9).y.T


# %%
# The same fit for both systems and both libraries. Nothing is swept; the fixed library is PySINDy's
# own, with its defaults.


def fit(library, optimizer, x, x_dot):
    """Fit an ordinary SINDy model."""
    model = ps.SINDy(feature_library=library, optimizer=optimizer)
    return model.fit(x, t, x_dot=x_dot, feature_names=["q", "v"])


rng = np.random.default_rng(0)
noise = 10 ** (-30 / 20)  # of the RMS
figure, axes = plt.subplots(2, 1, figsize=(9, 6), sharex=True, layout="constrained")
for axis, (name, (acceleration, start, held_out)) in zip(axes, SYSTEMS.items(), strict=True):
    x = swing(acceleration, start)
    measured = acceleration(*x.T)
    measured += noise * np.sqrt(np.mean(measured**2)) * rng.standard_normal(len(t))
    x_dot = np.column_stack([x[:, 1], measured])
    models = {
        "cubic polynomials": fit(ps.PolynomialLibrary(degree=3), ps.STLSQ(), x, x_dot),
        "evolved library": fit(pse.EvolvingLibrary(random_state=0), pse.ElasticNet(), x, x_dot),
    }
    truth = swing(acceleration, held_out)[:, 0]
    axis.plot(t, truth, "k", lw=5, alpha=0.25, label="truth")
    styles = ({"color": "tab:orange", "lw": 2.5}, {"color": "tab:blue", "ls": "--", "lw": 1.5})
    for (library, model), style in zip(models.items(), styles, strict=True):
        run = pse.simulate(model, [held_out, 0.0], t)[:, 0]
        error = 100 * np.sqrt(np.mean((run - truth) ** 2)) / truth.std()
        print(f"{name}: {library}, free run error {error:.2f} %")
        print(pse.export.format_equations(model), end="\n\n")
        axis.plot(t, run, **style, label=f"{library}: {error:.2g} %")
    axis.set(title=name, ylabel="q", ylim=1.5 * np.array([-1, 1]) * np.abs(truth).max())
    axis.set(xlim=(0, 20))
    axis.legend(loc="upper right", ncols=3)
    axis.spines[["top", "right"]].set_visible(False)
axes[1].set_xlabel("time (s)")
plt.show()
