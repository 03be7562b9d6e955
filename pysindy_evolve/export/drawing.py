"""Lays a tree of labels out on a page and draws it; the only file here that needs matplotlib.

All lengths are inches on the page, so that boxes fit their labels. A tree that would be wider than
a page is drawn on its side.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.patches import FancyBboxPatch, PathPatch
from matplotlib.path import Path
from matplotlib.textpath import TextPath

from .tree import Node

FONT_SIZE = 11.0  # points
HEIGHT = 0.32  # of a box
PADDING = 0.11  # between a label and the end of its box
GAP = 0.16  # between neighbors
LEVEL = 0.62  # from one level to the next, upright
MAX_WIDTH = 11.0  # of an upright tree
# Face, edge and text of each kind; they also differ in lightness.
COLORS = {
    "left": ("none", "none", "#1b2733"),
    "operator": ("#33475b", "#33475b", "#ffffff"),
    "function": ("#2a7ab9", "#2a7ab9", "#ffffff"),
    "coefficient": ("#fdf1dc", "#e0a030", "#6b4300"),
    "constant": ("#f3f4f6", "#9aa5b1", "#323f4b"),
    "variable": ("#e3f4e8", "#4f9d69", "#17472a"),
}


@dataclass(frozen=True)
class _Placed:
    """A node with its place: along the levels (center or left edge), and across (center)."""

    node: Node
    along: float
    across: float
    children: tuple[_Placed, ...]

    def walk(self) -> Iterator[_Placed]:
        yield self
        for child in self.children:
            yield from child.walk()

    def moved(self, distance: float) -> _Placed:
        children = tuple(child.moved(distance) for child in self.children)
        return _Placed(self.node, self.along, self.across + distance, children)


def draw(root: Node, ax: Any = None) -> Any:
    """Draw a tree, upright if it fits the page, else on its side; return the axes."""
    upright = True
    placed, _ = _place(root, _width, _steps(root, True), 0, 0.0)
    if _span(placed, upright)[0] > MAX_WIDTH:
        upright = False
        placed, _ = _place(root, _extent_sideways, _steps(root, False), 0, 0.0)
    width, height = _span(placed, upright)
    if ax is None:
        ax = plt.figure(figsize=(width, height)).add_axes((0.0, 0.0, 1.0, 1.0))
    scale = _frame(ax, placed, upright)
    for place in placed.walk():
        for child in place.children:
            _edge(ax, place, child, upright, scale)
    for place in placed.walk():
        _box(ax, place, upright, scale)
    return ax


def _place(
    node: Node, extent: Any, steps: list[float], level: int, along: float
) -> tuple[_Placed, tuple[list[float], list[float]]]:
    """Place a node at across = 0 with its children centered under it.

    Also return its contour: the smallest and the largest position across that it takes, level by
    level. Neighbors move together until their contours touch (Reingold and Tilford).
    """
    children: list[_Placed] = []
    low: list[float] = []
    high: list[float] = []
    for child in node.children:
        placed, (left, right) = _place(child, extent, steps, level + 1, along + steps[level])
        shift = max((h - b + GAP for h, b in zip(high, left, strict=False)), default=0.0)
        children.append(placed.moved(shift))
        left, right = [b + shift for b in left], [b + shift for b in right]
        low = low + left[len(low) :] if low else left
        high = right + high[len(right) :]
    middle = (children[0].across + children[-1].across) / 2 if children else 0.0
    half = extent(node) / 2
    contour = [-half] + [b - middle for b in low], [half] + [b - middle for b in high]
    return _Placed(node, along, 0.0, tuple(c.moved(-middle) for c in children)), contour


def _extent_sideways(node: Node) -> float:
    return HEIGHT


def _steps(root: Node, upright: bool) -> list[float]:
    """Return the distance from each level to the next: between centers, or between left edges.

    It grows with the largest number of children of one node, for their lines.
    """
    widths, fans = [0.0] * (root.depth + 1), [0] * (root.depth + 1)
    stack = [(root, 0)]
    while stack:
        node, level = stack.pop()
        widths[level] = max(widths[level], _width(node))
        fans[level] = max(fans[level], len(node.children))
        stack += [(child, level + 1) for child in node.children]
    if upright:
        return [LEVEL + 0.04 * max(fan - 2, 0) for fan in fans]
    return [w + 2.2 * GAP + min(0.06 * fan, 0.9) for w, fan in zip(widths, fans, strict=True)]


def _width(node: Node) -> float:
    text = TextPath((0, 0), node.label.replace("$", "S"), size=FONT_SIZE).get_extents().width / 72
    return max(float(text) + 2 * PADDING, HEIGHT)


def _span(placed: _Placed, upright: bool) -> tuple[float, float]:
    """Return width and height of the page."""
    left, right, bottom, top = _limits(placed, upright)
    return right - left, top - bottom


def _limits(placed: _Placed, upright: bool) -> tuple[float, float, float, float]:
    boxes = [(*_center(place, upright), _width(place.node) / 2) for place in placed.walk()]
    return (
        min(x - half for x, _, half in boxes) - GAP,
        max(x + half for x, _, half in boxes) + GAP,
        min(y for _, y, _ in boxes) - HEIGHT / 2 - GAP,
        max(y for _, y, _ in boxes) + HEIGHT / 2 + GAP,
    )


def _center(at: _Placed, upright: bool) -> tuple[float, float]:
    return (at.across, -at.along) if upright else (at.along + _width(at.node) / 2, -at.across)


def _frame(ax: Any, placed: _Placed, upright: bool) -> float:
    """Center the tree in the axes; return the factor, at most 1, by which it has to shrink."""
    left, right, bottom, top = _limits(placed, upright)
    box = ax.get_window_extent().transformed(ax.figure.dpi_scale_trans.inverted())
    scale = float(min(box.width / (right - left), box.height / (top - bottom), 1.0))
    x, y = (left + right) / 2, (bottom + top) / 2
    dx, dy = box.width / scale / 2, box.height / scale / 2
    ax.set(xlim=(x - dx, x + dx), ylim=(y - dy, y + dy), aspect="equal")
    ax.axis("off")
    return scale


def _edge(ax: Any, place: _Placed, child: _Placed, upright: bool, scale: float) -> None:
    """Draw a curve that leaves and enters the boxes at right angles."""
    (x0, y0), (x1, y1) = _center(place, upright), _center(child, upright)
    if upright:
        y0, y1 = y0 - HEIGHT / 2, y1 + HEIGHT / 2
        bend = [(x0, (y0 + y1) / 2), (x1, (y0 + y1) / 2)]
    else:
        x0, x1 = x0 + _width(place.node) / 2, x1 - _width(child.node) / 2
        bend = [((x0 + x1) / 2, y0), ((x0 + x1) / 2, y1)]
    path = Path([(x0, y0), *bend, (x1, y1)], [Path.MOVETO, *[Path.CURVE4] * 3])
    ax.add_patch(PathPatch(path, fill=False, edgecolor="#8795a5", linewidth=1.2 * scale, zorder=1))


def _box(ax: Any, place: _Placed, upright: bool, scale: float) -> None:
    x, y = _center(place, upright)
    face, edge, text = COLORS[place.node.kind]
    width = _width(place.node)
    corner = HEIGHT / 2 if place.node.kind in ("operator", "variable") else 0.08
    style = f"round,pad=0,rounding_size={corner}"
    ax.add_patch(
        FancyBboxPatch(
            (x - width / 2, y - HEIGHT / 2),
            width,
            HEIGHT,
            boxstyle=style,
            facecolor=face,
            edgecolor=edge,
            linewidth=1.1 * scale,
            zorder=2,
        )
    )
    ax.text(
        x, y, place.node.label, color=text, fontsize=FONT_SIZE * scale, ha="center",
        va="center_baseline", zorder=3, parse_math=False,
    )  # fmt: skip
