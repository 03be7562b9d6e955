"""The panels of a residual: over time, frequency, one variable, and a plane of two variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.signal import welch
from scipy.stats import binned_statistic_2d

N_TIMES = 240  # bins over time
N_BINS = 30  # bins over a variable, of equally many samples, at most
LEAST_IN_BIN = 30  # samples; fewer bins are drawn if these are not reached
N_FREQUENCIES = 60  # bins over frequency
N_CELLS = (6, 28)  # fewest and most cells along each side of a plane
LEAST_IN_CELL = 3  # samples; cells with fewer stay blank
FEW_DECADES = 2.1  # with no more, a logarithmic axis has a tick at 1, 2 and 5 of each


@dataclass(frozen=True)
class Band:
    """How the spread of a signal is drawn: between two quantiles, with a line along a third."""

    quantiles: tuple[float, float, float]
    alpha: float
    width: float

    def draw(
        self, axes: Any, places: Sequence[float], bins: Sequence[np.ndarray], color: str, label: str
    ) -> None:
        """Draw the samples of each bin at its place."""
        low, middle, high = np.array([np.quantile(values, self.quantiles) for values in bins]).T
        axes.fill_between(places, low, high, color=color, alpha=self.alpha, lw=0)
        axes.plot(places, middle, color=color, lw=self.width, label=label)


OVER_TIME = Band((0.1, 0.5, 0.9), alpha=0.3, width=0.9)
OVER_VARIABLE = Band((0.25, 0.5, 0.75), alpha=0.25, width=1.6)


def tidy(axes: Any, x: str, y: str, title: str) -> None:
    """Label axes, and remove the frame on the right and at the top."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, loc="left")
    axes.spines[["top", "right"]].set_visible(False)


def label_decades(axes: Any) -> None:
    """Put numbers on both logarithmic axes, more than one a decade where there are few."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    if not any(np.any(line.get_ydata() > 0.0) for line in axes.lines):
        return
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        is_short = np.log10(high / low) <= FEW_DECADES
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if is_short else (1.0,)))
        axis.set_minor_formatter(NullFormatter())
        if is_short:
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))


def draw_time(axes: Any, t: np.ndarray, residual: np.ndarray, color: str, label: str) -> None:
    """Draw a signal over time; if it has many samples, their median and the band of 80 %.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    t, residual : ndarray of shape (n_samples,)
        Time and signal.
    color, label : str
        Of the line.
    """
    if len(t) <= 2 * N_TIMES:
        axes.plot(t, residual, color=color, lw=1.0, label=label)
        return
    parts = np.array_split(np.arange(len(t)), N_TIMES)
    centers = [t[part].mean() for part in parts]
    OVER_TIME.draw(axes, centers, [residual[part] for part in parts], color, label)


def draw_variable(axes: Any, x: np.ndarray, residual: np.ndarray, color: str, label: str) -> None:
    """Draw the median of a signal over a variable, and the band that holds the middle half.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    x, residual : ndarray of shape (n_samples,)
        Variable and signal.
    color, label : str
        Of the line.
    """
    order = np.argsort(x, kind="stable")
    n_bins = int(np.clip(len(x) // LEAST_IN_BIN, 4, N_BINS))
    bins = [part for part in np.array_split(order, min(n_bins, len(x))) if len(part)]
    centers = [float(np.median(x[part])) for part in bins]
    OVER_VARIABLE.draw(axes, centers, [residual[part] for part in bins], color, label)


def draw_frequency(
    axes: Any, signal: np.ndarray, dt: float, highest: float, color: str, label: str
) -> None:
    """Draw the amplitude spectral density of a signal up to a frequency.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    signal : ndarray of shape (n_samples,)
        On a uniform grid.
    dt : float
        Sampling time.
    highest : float
        Frequency to draw up to; above the cutoff of a record there is nothing.
    color, label : str
        Of the line.
    """
    length = min(len(signal), max(256, len(signal) // 6))
    frequencies, power = welch(signal, 1.0 / dt, nperseg=length)
    shown = (frequencies > 0.0) & (frequencies <= highest)
    frequencies, power = frequencies[shown], power[shown]
    if not len(frequencies):
        return
    # Bins of equal width on the logarithmic axis; the lowest hold one frequency each.
    edges = np.geomspace(frequencies[0], frequencies[-1], N_FREQUENCIES)
    place = np.unique(np.searchsorted(frequencies, edges[:-1]))
    parts = [slice(a, b) for a, b in pairwise([*place, len(frequencies)])]
    centers = [frequencies[part].mean() for part in parts]
    density = [np.sqrt(power[part].mean()) for part in parts]
    axes.loglog(centers, density, color=color, lw=1.4, label=label)


def draw_plane(axes: Any, x: np.ndarray, y: np.ndarray, residual: np.ndarray, limit: float) -> Any:
    """Color the cells of a plane by the mean of a signal there.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    x, y, residual : ndarray of shape (n_samples,)
        Coordinates and signal.
    limit : float
        Value at both ends of the colors.

    Returns
    -------
    matplotlib.collections.QuadMesh
        What a color bar needs.
    """
    n_cells = int(np.clip(np.sqrt(len(x) / 12), *N_CELLS))
    mean, x_edges, y_edges, _ = binned_statistic_2d(x, y, residual, "mean", n_cells)
    count, *_ = binned_statistic_2d(x, y, residual, "count", [x_edges, y_edges])
    masked = np.ma.masked_where(count < LEAST_IN_CELL, mean)
    return axes.pcolormesh(
        x_edges, y_edges, masked.T, cmap="RdBu_r", vmin=-limit, vmax=limit, rasterized=True
    )


def draw_twins(axes: Any, scores: np.ndarray, observed: float, color: str) -> None:
    """Draw the scores of twins as a histogram, and the observed one as a line.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    scores : ndarray of shape (n_twins,)
        Best score of each twin.
    observed : float
        Score in the record.
    color : str
        Of the line.
    """
    low, high = min(0.0, float(scores.min())), max(float(scores.max()), observed)
    axes.hist(scores, np.linspace(low, high, 31), color="#9aa5b1")
    axes.axvline(observed, color=color, lw=2)
    axes.set_xlim(low - 0.03 * (high - low), high + 0.05 * (high - low) + 1e-12)
    side = "right" if observed > 0.5 * (low + high) else "left"
    axes.annotate(
        "this record", (observed, 1.0), xycoords=("data", "axes fraction"), ha=side,
        color=color, textcoords="offset points", xytext=(0, 3), annotation_clip=False,
    )  # fmt: skip
    axes.yaxis.get_major_locator().set_params(integer=True)
