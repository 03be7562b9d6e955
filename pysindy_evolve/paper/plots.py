"""Pictures of records, of measured against identified accelerations, and of accuracy over noise.

This file needs matplotlib, so it is imported only when something is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np

from .facts import CLEAN_DOWN_TO
from .tables import accuracy

if TYPE_CHECKING:
    from ..datasets import DuffingRig
    from .trials import Identified, Trial

DARK, LIGHT, RED = "#24476b", "#9db4cc", "#c0392b"
WIDTH = 6.3  # inches: the text of a page
CLOSE_UP = 0.6  # s of the validation part, around its largest acceleration
MAX_POINTS = 6000  # of a scatter plot
STYLE = {
    "font.family": "serif",
    "mathtext.fontset": "dejavuserif",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "lines.linewidth": 0.8,
    "savefig.dpi": 250,
}
LABELS = {
    "t": "time $t$ (s)",
    "q": "displacement $q$ (mm)",
    "v": r"velocity $\dot{q}$ (m/s)",
    "a": r"acceleration $\ddot{q}$ (m/s$^2$)",
    "zdd": r"table $\ddot{z}$ (m/s$^2$)",
}


def style() -> Any:
    """Return a context with the style of the printed figures."""
    return plt.rc_context(STYLE)


def save(figure: Any, path: Path) -> Path:
    """Write a figure as PDF and PNG, close it, and return the PNG."""
    for ending in (".pdf", ".png"):
        figure.savefig(path.with_suffix(ending))
    plt.close(figure)
    return path.with_suffix(".png")


def input_and_output(rig: DuffingRig) -> Any:
    """Draw input, displacement and measured acceleration over time (figure 4)."""
    figure, axes = plt.subplots(3, 1, figsize=(WIDTH, 4.2), sharex=True, layout="constrained")
    _over_time(axes, rig)
    return figure


def phase_plane(rig: DuffingRig) -> Any:
    """Draw velocity over displacement (figure 5)."""
    figure, axes = plt.subplots(figsize=(0.55 * WIDTH, 0.48 * WIDTH), layout="constrained")
    _orbit(axes, rig)
    return figure


def record(rig: DuffingRig) -> Any:
    """Draw the signals over time beside the phase plane (figure 11)."""
    figure = plt.figure(figsize=(WIDTH, 3.6), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(3, 2))
    first = figure.add_subplot(grid[0, 0])
    below = [figure.add_subplot(grid[i, 0], sharex=first) for i in (1, 2)]
    _over_time([first, *below], rig)
    _orbit(figure.add_subplot(grid[:, 1]), rig)
    return figure


def comparison(found: Mapping[str, Identified]) -> Any:
    """Draw measured and identified acceleration of the validation part (figures 9 and 13).

    One row for each record: all of it, a close-up around the largest acceleration, a scatter plot.
    """
    height = 0.3 + 1.7 * len(found)
    figure, axes = plt.subplots(
        len(found), 3, figsize=(WIDTH, height), width_ratios=(2.2, 2.2, 1.6), squeeze=False,
        layout="constrained",
    )  # fmt: skip
    for row, (name, one) in zip(axes, found.items(), strict=True):
        _compare(row, one)
        row[0].set_title(name, loc="left")
    for ax, label in zip(axes[-1], (LABELS["t"], LABELS["t"], "measured (m/s$^2$)"), strict=True):
        ax.set_xlabel(label)
    axes[0, 1].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)
    return figure


def accuracy_over_noise(trials: Mapping[float, Sequence[Trial]]) -> Any:
    """Draw accuracy, mean and standard deviation, and share of exact structures (figure 10)."""
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(0.75 * WIDTH, 3.6), sharex=True, height_ratios=(2, 1), layout="constrained"
    )
    finished = {snr: found for snr, found in trials.items() if found}
    snr = np.array(list(finished))
    mean, deviation = np.array([accuracy(found) for found in finished.values()]).reshape(-1, 2).T
    above.errorbar(
        snr, mean, deviation, color=DARK, marker="o", ms=3.5, capsize=2.5, elinewidth=0.8, lw=1.0
    )
    above.set_ylabel("accuracy (%)")
    for share, marker, color, label in (
        ([100.0 * np.mean([t.exact for t in f]) for f in finished.values()], "s", DARK, "exact"),
        ([100.0 * np.mean([not t.extra for t in f]) for f in finished.values()], "x", RED,
         "without extra terms"),
    ):  # fmt: skip
        below.plot(snr, share, marker, color=color, ms=4, label=label, clip_on=False, mfc="none")
    below.set(ylim=(0, 105), ylabel="runs (%)", xlabel="signal-to-noise ratio (dB)")
    below.legend(loc="lower left")
    for ax in (above, below):
        ax.axvline(CLEAN_DOWN_TO, color="0.6", lw=0.7, ls=(0, (4, 3)), zorder=0)
    above.annotate(
        "paper: extra terms\nleft of this line", (CLEAN_DOWN_TO, 0.06), (-4, 0),
        xycoords=("data", "axes fraction"), textcoords="offset points", color="0.4", ha="right",
    )  # fmt: skip
    return figure


def _over_time(axes: Sequence[Any], rig: DuffingRig) -> None:
    """Draw table, displacement and acceleration as measured, validation part shaded."""
    at = slice(rig.validation.start, rig.train.stop)
    signals = {"zdd": rig.u[at, 0], "q": 1e3 * rig.x[at, 0], "a": rig.x_dot[at, 1]}
    for ax, (name, signal) in zip(axes, signals.items(), strict=True):
        ax.plot(rig.t[at], signal, color=DARK, lw=0.3, rasterized=True)
        ax.axvspan(rig.t[at][0], rig.t[rig.validation.stop], color="#f3e3c3", lw=0, zorder=0)
        ax.set_ylabel(LABELS[name].replace(" (", "\n("))
        ax.margins(x=0.0)
    middle = (rig.t[at][0] + rig.t[rig.validation.stop]) / 2
    axes[0].set_title("validation", x=middle / rig.t[at][-1], ha="center", color="#8a6d2f")
    axes[-1].set_xlabel(LABELS["t"])


def _orbit(ax: Any, rig: DuffingRig) -> None:
    at = slice(rig.validation.start, rig.train.stop)
    ax.plot(1e3 * rig.x[at, 0], rig.x[at, 1], color=DARK, lw=0.15, alpha=0.6, rasterized=True)
    ax.set(xlabel=LABELS["q"], ylabel=LABELS["v"])


def _compare(row: Sequence[Any], found: Identified) -> None:
    at = found.rig.validation
    t, measured, identified = found.rig.t[at], found.rig.x_dot[at, 1], found.predicted
    whole, close, against = row
    peak = t[np.argmax(np.abs(measured))]
    near = np.abs(t - min(peak, t[-1] - CLOSE_UP / 2)) <= CLOSE_UP / 2
    for ax, rows in ((whole, slice(None)), (close, near)):
        ax.plot(t[rows], measured[rows], color=LIGHT, label="measured", rasterized=True)
        ax.plot(t[rows], identified[rows], color=RED, lw=0.6, label="identified", rasterized=True)
        ax.margins(x=0.0)
    whole.set_ylabel(LABELS["a"])
    step = max(len(t) // MAX_POINTS, 1)
    against.plot(
        measured[::step], identified[::step], ".", color=DARK, ms=1.2, alpha=0.4, mew=0,
        rasterized=True,
    )  # fmt: skip
    limit = 1.05 * max(np.abs(measured).max(), np.abs(identified).max())
    against.plot([-limit, limit], [-limit, limit], color=RED, lw=0.6)
    against.set(xlim=(-limit, limit), ylim=(-limit, limit), ylabel="identified", aspect="equal")
