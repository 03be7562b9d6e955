"""
Dry friction found in a shaking table rig
=========================================

**Claim.** From a noisy acceleration alone, the library grows the two dry friction terms that
nobody put into it, one of them growing with the square of the displacement, and the identified
model sticks and slips like the rig.

The rig is the Duffing oscillator with dry friction of Goharoodi et al. (2020), simulated: a mass
between springs on a shaking table, 279 000 samples to fit on, noise of 30 dB on the acceleration.
"""

import matplotlib.pyplot as plt
import numpy as np
import pysindy as ps

import pysindy_evolve as pse
from pysindy_evolve.datasets import rigs

# %%
# Fit. The operators are the paper's; the library starts from random terms.

rig = rigs.duffing(friction=True, snr_db=30)
fit, held_out = rig.record("train"), rig.record("validation")

model = ps.SINDy(
    feature_library=pse.EvolvingLibrary(
        operators=("add", "sub", "mul", "abs", "sgn"), random_state=0
    ),
    optimizer=pse.ElasticNet(),
)
model.fit(fit.x, fit.t, x_dot=fit.x_dot, u=fit.u, feature_names=list(rig.names))
model.print()

# %%
# Six terms, and no others. The truth is
# -1.23 v - 714.6 q - 2.24e6 q^3 - 4.11 sgn(v) - 8.23e3 q^2 sgn(v) - 1.04 zdd.
#
# For comparison, a fixed library of all cubic polynomials, by least squares.

smooth = ps.SINDy(
    feature_library=ps.PolynomialLibrary(3, include_bias=False),
    optimizer=ps.STLSQ(threshold=0.0, alpha=1e-9, normalize_columns=True),
)
smooth.fit(fit.x, fit.t, x_dot=fit.x_dot, u=fit.u, feature_names=list(rig.names))

# %%
# Free run over the first 18 s of the held-out part: from rest, the measured table motion as
# input, nothing fed back.

part = slice(0, 36_000)
t, u, start = held_out.t[part], held_out.u[part], [0.0, 0.0]
runs = {"cubic polynomials": pse.simulate(smooth, start, t, u)}
runs["evolved library"] = pse.simulate(model, start, t, u)
truth = rig.q[rig.validation][part]
for name, x in runs.items():
    error = 100 * np.sqrt(np.mean((x[:, 0] - truth) ** 2)) / np.std(truth)
    print(f"{name}: free run error {error:.2f} %")

# %%
# What is left of the measured acceleration without the smooth terms of the identified model is
# friction: two branches that part as the mass moves away from the middle.

theta, coef = np.asarray(model.feature_library.transform(np.c_[fit.x, fit.u])), model.coefficients()
signed = np.array(["sgn" in name or "abs" in name for name in model.get_feature_names()])
friction = fit.x_dot[:, 1] - theta[:, ~signed] @ coef[1, ~signed]
some = np.random.default_rng(0).choice(np.flatnonzero(np.abs(fit.x[:, 1]) > 0.05), 6_000)

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
zoom = slice(0, 3_000)
left.plot(t[zoom], 1e3 * truth[zoom], "k", lw=3, alpha=0.4, label="rig")
for (name, x), color in zip(runs.items(), ("tab:orange", "tab:blue"), strict=True):
    left.plot(t[zoom], 1e3 * x[zoom, 0], color, lw=1.2, label=name)
left.set(xlabel="time (s)", ylabel="displacement (mm)", title="Free run on held-out data")
left.set_ylim(-22, 15)
left.legend(loc="lower center", ncols=3)
right.scatter(1e3 * fit.x[some, 0], friction[some], s=2, c=np.sign(fit.x[some, 1]), cmap="coolwarm")
right.set(xlabel="displacement (mm)", ylabel="acceleration by friction (m/s²)")
right.set_title("Dry friction, velocity to the right (red) and left (blue)")
plt.show()
