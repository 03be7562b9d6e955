"""
A fixed library against an evolved one
======================================

**Claim.** Where the truth lies in the fixed library, evolving it wins nothing. Where it does not,
the evolved library finds the terms, and its model holds beyond the motion it was fitted on.

Four systems, each fitted on one motion with noise of 30 dB on the derivative and judged on another.
The fixed library is PySINDy's polynomials of degree 3, the best of fourteen thresholds by BIC.
"""

import matplotlib.pyplot as plt
import numpy as np
import pysindy as ps
from scipy.integrate import solve_ivp

import pysindy_evolve as pse


def motion(slope, start, stop):
    """Return time, states, true slopes and no input."""
    t = np.linspace(0.0, stop, 4001)
    x = solve_ivp(lambda _, x: slope(*x), (0.0, stop), start, t_eval=t, rtol=1e-9, atol=1e-9).y.T
    return t, x, np.column_stack(slope(*x.T)), None


rig = pse.datasets.duffing(friction=True, n_samples=40_000)  # a sweep of 20 s
rows = [(rig.t[p], rig.x[p], rig.x_dot[p], rig.u[p]) for p in (rig.train, rig.validation)]
swing = lambda q, v: (v, -9.81 * np.sin(q) - 0.1 * v * np.abs(v))  # noqa: E731
prey = lambda x, y: (x - 0.2 * x**2 - 2 * x * y / (1.5 + x), 1.2 * x * y / (1.5 + x) - 0.5 * y)  # noqa: E731
lorenz = lambda x, y, z: (10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z)  # noqa: E731
SYSTEMS = {  # names, motion to fit, motion to judge on, true number of terms
    "Rig with dry friction": ("q v zdd", *rows, 7),
    "Pendulum with air drag": ("q v", motion(swing, [2, 0], 20), motion(swing, [-2.4, 0], 20), 3),
    "Predator that saturates": ("x y", motion(prey, [2, 1], 60), motion(prey, [4.5, 0.3], 60), 5),
    "Lorenz": ("x y z", motion(lorenz, [1, 1, 20], 10), motion(lorenz, [-5, -8, 20], 3), 7),
}

# %%
# The same two fits for all systems; both give ordinary SINDy models.


def fixed(x, x_dot, operators, **options):
    """Sweep the threshold of STLSQ, as it comes and with columns of unit size."""

    def bic(model):
        error = np.mean((np.asarray(model.predict(x, u=options["u"])) - x_dot) ** 2, axis=0)
        n_terms = np.count_nonzero(model.coefficients())
        return len(x) * np.log(error).sum() + np.log(len(x)) * n_terms

    sizes = np.linalg.norm(x_dot) / 2 * np.logspace(-3.5, -0.5, 7)
    stlsq = [ps.STLSQ(share) for share in np.logspace(-2, 0, 7)]
    stlsq += [ps.STLSQ(size, normalize_columns=True) for size in sizes]
    models = [ps.SINDy(feature_library=ps.PolynomialLibrary(3), optimizer=s) for s in stlsq]
    return min((model.fit(x, x_dot=x_dot, **options) for model in models), key=bic)


def evolved(x, x_dot, operators, **options):
    """Grow the library."""
    library, optimizer = pse.EvolvingLibrary(operators, random_state=0), pse.ElasticNet()
    return ps.SINDy(feature_library=library, optimizer=optimizer).fit(x, x_dot=x_dot, **options)


rng = np.random.default_rng(0)
rms = lambda a: np.sqrt(np.mean(np.square(a), axis=0))  # noqa: E731
figure, axes = plt.subplots(2, 2, figsize=(11, 6), layout="constrained")
for axis, name in zip(axes.flat, SYSTEMS, strict=True):
    names, fit, (t, x, x_dot, u), n_true = SYSTEMS[name]
    operators = ("add", "sub", "mul", "div", "sin", "cos", "abs", "sgn")  # the default
    if name.startswith("Predator"):
        operators = operators[:4]  # animals do not count in waves
    moves = fit[1][:, 1] != 0.0  # a mass at rest follows no equation
    t_fit, x_fit, clean, u_fit = (None if column is None else column[moves] for column in fit)
    noisy = clean + 10 ** (-30 / 20) * rms(clean) * rng.standard_normal(clean.shape)
    axis.plot(t, x[:, 0], "k", lw=5, alpha=0.2, label="truth")
    axis.margins(x=0, y=0.3)
    axis.set(title=name, xlabel="time", ylabel=names[0], ylim=axis.get_ylim())
    for method, style in ((fixed, "C1"), (evolved, "C0--")):
        model = method(x_fit, noisy, operators, t=t_fit, u=u_fit, feature_names=names.split())
        wrong = (np.asarray(model.predict(x, u=u)) - x_dot)[x[:, 1] != 0.0]
        error = 100 * np.max(rms(wrong) / x_dot.std(axis=0))
        run = pse.simulate(model, x[0], t, u=u)
        off = 100 * np.max(rms(run - x) / x.std(axis=0))
        found = f"{np.count_nonzero(model.coefficients())} terms of {n_true}"
        print(f"{name}, {method.__name__}: {found}; slopes off by {error:.3g} %, run {off:.3g} %")
        print(pse.export.format_equations(model), end="\n\n")
        axis.plot(t, run[:, 0], style, label=f"{method.__name__}: {off:.3g} %")
    axis.legend(loc="upper right", ncols=3)
plt.show()
