"""
Where nothing is missing, nothing is found
==========================================

**Claim.** A declared model that is complete is called complete, and what it leaves of the
measured acceleration is the noise of the encoder and nothing else.

The rig is a simulated linear axis without dry friction. Its model, viscous damping and a motor, is
right, and only its two coefficients are free. The encoder has noise of 5 micrometers and steps of
1 micrometer.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import welch

import pysindy_evolve as pse

# %%
# The loop tries every effect that it knows and terms that it evolves. An effect counts only if it
# does better here than in twins, simulated records in which nothing is missing.

drive = pse.datasets.nothing_missing()
train, test = (pse.prepare(r.t, r.y, r.u) for r in (drive.train, drive.test))
declared = pse.DeclaredModel(drive.declared, inputs=["F"])
report = pse.close_loop(declared, train, test=test, random_state=0)
print(report)

# %%
# Is what remains only noise? White noise, as strong as the encoder's, goes through the same
# filter and differentiation, and through the model.

record, rng = report.test[0], np.random.default_rng(0)
made = record.preparation
noise = made.apply(made.t, made.noise * rng.standard_normal(made.y.shape), 0.0 * made.u)
expected = noise.x_dot - report.equations.evaluate(noise.x, noise.u)
left = report.residual_after[0]

figure, (over_v, over_f) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
over_v.plot(
    record.x[:, 1], record.x_dot[:, 1], ".", ms=1.5, color="0.75", label="measured acceleration"
)
over_v.plot(
    record.x[:, 1], left[:, 1], ".", ms=1.5, color="tab:blue", label="residual of the model"
)
over_v.set(xlabel="velocity (m/s)", ylabel="acceleration (m/s²)", title="Held-out record")
over_v.set_ylim(-3.2, 4.4)
over_v.legend(markerscale=8, loc="upper left", frameon=False)
for column, style, label in (
    (left, {"color": "tab:blue", "lw": 2.5}, "residual of the model"),
    (expected, {"color": "k", "ls": "--", "lw": 1.2}, "encoder noise alone"),
):
    f, power = welch(column[:, 1], 1.0 / record.dt, nperseg=512)
    over_f.loglog(f[1:], np.sqrt(power[1:]), **style, label=label)
over_f.axvline(made.cutoff, color="0.6", lw=0.8)
over_f.annotate(
    "low-pass", (0.97 * made.cutoff, 1.2e-6), rotation=90, ha="right", va="bottom", color="0.4"
)
over_f.set(xlabel="frequency (Hz)", ylabel="amplitude density (m/s² per √Hz)")
over_f.set(title="Spectrum of the residual", ylim=(1e-6, None))
over_f.legend(loc="upper left", frameon=False)
for axes in (over_v, over_f):
    axes.spines[["top", "right"]].set_visible(False)
plt.show()
