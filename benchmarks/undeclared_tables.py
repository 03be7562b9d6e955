"""The tables of undeclared.py: how often something was named, and whether it was right."""

from collections import defaultdict

import numpy as np
from machines.effects import effects_of
from machines.systems import SYSTEMS
from scipy.stats import beta


def interval(k, n):
    """Return the 95 % Clopper-Pearson interval of a rate, percent."""
    low = 0.0 if k == 0 else beta.ppf(0.025, k, n - k + 1)
    high = 1.0 if k == n else beta.ppf(0.975, k + 1, n - k)
    return 100 * low, 100 * high


def grouped(rows, key):
    groups = defaultdict(list)
    for r in rows:
        groups[key(r)].append(r)
    return groups


def print_nulls(rows):
    """Print how often an effect was named, or the verdict was "untraced" without a name."""
    heads = f"{'runs':>6}{'named':>7}{'rate %':>8}{'95 %':>14}{'untraced':>10}   names"
    print(f"\n{'nothing missing':<20}{heads}")
    by_system = grouped(rows, lambda r: "  " + r["system"])
    for kind, group in {**grouped(rows, lambda r: r["kind"]), **by_system, "all": rows}.items():
        k, n = sum(bool(r["names"]) for r in group), len(group)
        low, high = interval(k, n)
        lost = sum(r["verdict"] == "untraced" for r in group)
        names = defaultdict(int)
        for r in group:
            for name in r["names"][:1]:
                names[name] += 1
        shown = ", ".join(f"{v} {k}" for k, v in sorted(names.items(), key=lambda x: -x[1]))
        rate = f"{100 * k / n:>8.1f}{low:>6.1f} -{high:>5.1f}"
        print(f"{kind:<20}{n:>6}{k:>7}{rate}{lost:>9}    {shown}")
    print(f"median seconds a loop: {np.median([r['seconds'] for r in rows]):.2f}")


def judged(r):
    """Return whether anything, the right first, the right at all was named, and the extras."""
    right = effects_of(SYSTEMS[r["system"]])[r["effect"]][1]
    if right is None:
        return bool(r["names"]), np.nan, np.nan, max(0, len(r["names"]) - 1)
    first = bool(r["names"]) and bool(right & {r["names"][0], *r["alternatives"][0]})
    hits = [bool(right & {n, *a}) for n, a in zip(r["names"], r["alternatives"], strict=True)]
    return bool(r["names"]), float(first), float(any(hits)), len(hits) - sum(hits)


def print_effects(rows):
    keys = (
        lambda r: (f"{100 * r['share']:g} %", f"noise {r['percent']:g} %"),
        lambda r: (r["effect"], f"{100 * r['share']:g} %"),
        lambda r: (r["system"], f"{100 * r['share']:g} %"),
    )
    for key in keys:
        print(
            f"\n{'':<28}{'runs':>5}{'named':>7}{'first':>7}{'found':>7}{'extra':>7}{'free<=1.2':>11}"
        )
        for label, group in sorted(grouped(rows, key).items()):
            scores = np.array([judged(r) for r in group], dtype=float)
            known = scores[~np.isnan(scores[:, 1])]
            first, found = known[:, 1:3].mean(axis=0) if len(known) else (np.nan, np.nan)
            runs = np.array([r["free_run"][1:] for r in group])  # a reference that diverges is none
            ratio = np.where(np.isfinite(runs[:, 1]), runs[:, 0] / runs[:, 1], np.nan)
            ratio = ratio[~np.isnan(ratio)]
            print(
                f"{' '.join(label):<28}{len(group):>5}{scores[:, 0].mean():>7.2f}{first:>7.2f}"
                f"{found:>7.2f}{scores[:, 3].mean():>7.2f}{(ratio <= 1.2).mean():>11.2f}"
            )
    print(f"median seconds a loop: {np.median([r['seconds'] for r in rows]):.2f}")
