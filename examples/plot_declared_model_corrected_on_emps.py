"""
A declared model corrected on a measured drive
==============================================

**Claim.** Given the model in its maker's words and one measured record, the loop names the dry
friction and the offset that the model lacks, and a free run over another record, never used for
any choice, follows the machine several times closer.

EMPS is a linear axis moved by a motor through a ball screw, recorded at 1 kHz (Janot, Gautier,
Brunot, 2019). The model is fitted on one record and judged on another one, with force pulses.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import pysindy_evolve as pse

try:
    emps = pse.datasets.load_emps()
except (OSError, ImportError) as error:  # neither on this machine nor to be downloaded
    print(f"The EMPS records are not here, so there is nothing to show. {error}")
    sys.exit(0)

# %%
# Newton's law and viscous friction: b is one over the mass, c the viscous friction over the mass.

train, test = (pse.prepare(r.t, r.y, r.u) for r in (emps["train"], emps["pulses"]))
declared = pse.DeclaredModel({"q": "v", "v": "b*F - c*v"}, inputs=["F"])
report = pse.close_loop(declared, train, test=test, random_state=0, n_jobs=-1)
print(report)

# %%
# Free run: from the first measured state, with the measured force, nothing fed back.

record = report.test[0]
runs = {
    "declared model": pse.simulate(report.before.model, record.x[0], record.t, record.u)[:, 0],
    "corrected model": report.simulate(record)[:, 0],
}
colors = dict(zip(runs, ("tab:orange", "tab:blue"), strict=True))

figure, (free, left) = plt.subplots(
    1, 2, figsize=(11, 4), width_ratios=(3, 2), layout="constrained"
)
free.plot(record.t, record.x[:, 0], "k", lw=4, alpha=0.3, label="measured")
for name, run in runs.items():
    rms = 1e3 * np.sqrt(np.mean((run - record.x[:, 0]) ** 2))
    free.plot(record.t, run, color=colors[name], lw=1.3, label=f"{name}, off by {rms:.0f} mm")
free.set(xlabel="time (s)", ylabel="position (m)", title="Free run over the held-out record")
free.set_ylim(top=free.get_ylim()[1] + 0.15)
free.legend(loc="upper left", frameon=False)

# %%
# What the declared model leaves of the acceleration jumps where the axis turns: dry friction. The
# single points come from the edges of the pulses, where the low-pass rings.

residuals = (report.residual_before[0], report.residual_after[0])
for (name, color), residual in zip(colors.items(), residuals, strict=True):
    left.plot(record.x[:, 1], residual[:, 1], ".", ms=1.5, color=color, label=name)
left.set(xlabel="velocity (m/s)", ylabel="residual (m/s²)", title="Acceleration left unexplained")
left.set_ylim(-0.9, 0.5)
left.legend(markerscale=8, loc="lower left", frameon=True, framealpha=1.0, edgecolor="white")
for axes in (free, left):
    axes.spines[["top", "right"]].set_visible(False)
plt.show()
