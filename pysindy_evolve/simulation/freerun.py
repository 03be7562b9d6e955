"""Free run: integrate equations sample by sample, locate every switch, stick and slip.

Between switches the signs are frozen and the right-hand side is smooth; a step whose error is too
large is cut, a step that ends beyond a switch is cut at the switch. There Filippov's rule decides
for every switch at zero: it goes up if both right-hand sides point up, down if both point down,
and slides (sticks) if they point at each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import repeat
from typing import Any

import numpy as np

from .limits import Diverged, Limits, TooManySteps, TooShortSteps
from .program import Program
from .structure import Switch

Vector = Sequence[float]

_FAILURES = (ArithmeticError, ValueError)  # what math raises where numpy gives inf or nan
_HUGE = math.inf
SAFETY, SHRINK, GROW, ORDER = 0.9, 0.2, 4.0, 0.2  # usual factors of a step-size controller
# Of a sample interval: shorter steps are never rejected, as at a jump without sgn.
MIN_STEP_SHARE = 1e-6
OUTGROWN = 2.0  # growth of a state at which the error weights are renewed
ROUNDING = 1e-14  # of the sum of the sizes of terms: rounding errors of a sum of many
LEAST_ERROR = 1e-290  # so that weights are finite
EVENT_TOLERANCE = 1e-12  # of the step in which a switch is located
MAX_EVENTS = 200  # in one sample interval; more would be chatter
MAX_FORCED = 200  # steps too short to be rejected, in one sample interval: no jumps, but chatter
SWEEPS = 60  # of the fixed-point iteration over several switches at zero
LIMIT = 1.0 - 1e-9  # largest magnitude of the equivalent sign at which a switch is held
SAMPLES_PER_CHUNK = 1024  # samples between two checks of the bound, and updates of the progress bar


@dataclass
class FreeRun:
    """One integration; `samples` yields the state at one sample after the other.

    Parameters
    ----------
    program : Program
        Compiled equations.
    parameters : sequence of float
        Values of the coefficients and inner constants.
    limits : Limits
        Tolerances.
    """

    program: Program
    parameters: Vector
    limits: Limits
    n_steps: int = 0
    trial: float = _HUGE
    signs: list[float] = field(default_factory=list)
    sliding: frozenset[int] = frozenset()

    def samples(self, x0: Vector, t: np.ndarray, u: np.ndarray) -> Iterator[Vector]:
        """Yield the state at t[1], t[2], ...; may raise `Diverged`."""
        x, p = list(x0), self.parameters
        self._size = self._weights = [0.0] * len(x)
        steps = np.diff(t)
        slopes = np.diff(u, axis=0) / steps[:, None]
        external = [i for i, switch in enumerate(self._switches) if switch.external]
        self.signs = [0.0] * len(self._switches)
        first = True
        rows = zip(t.tolist(), steps.tolist(), _rows(u), _rows(slopes), strict=False)
        for time, h, u_here, slope in rows:
            if first or external:
                try:
                    self._start(h, time, x, u_here, slope, first, external)
                    self._weigh(h, time, x, u_here)
                except _FAILURES as failure:
                    raise Diverged("the right-hand side has no value") from failure
                step, first = self.program.step(self.sliding), False
            if h <= self.trial and self.limits.substeps is None:
                self.n_steps += 1
                try:
                    after, _, lowest, error = step(
                        h, time, x, u_here, slope, self.signs, self._weights, p
                    )
                except _FAILURES:
                    error = math.nan
                if error <= 1.0 and lowest >= 0.0:
                    x = after
                    yield x
                    continue
            x = self._interval(h, time, x, u_here, slope)
            step = self.program.step(self.sliding)
            yield x

    @property
    def _switches(self) -> tuple[Switch, ...]:
        return self.program.structure.switches

    def _weigh(self, h: float, t: float, x: Vector, u: Vector) -> None:
        """Set the error weights of a step of length h, by the largest states so far.

        The rounding errors of the step are allowed as well: large terms may cancel and hold a
        state at zero.
        """
        self._size = [max(pair) for pair in zip(self._size, map(abs, x), strict=True)]
        rounding = self._rounding(h, t, x, u)
        tolerance = self.limits.tolerance
        self._weights = [
            1.0 / max(tolerance * size + error, LEAST_ERROR)
            for size, error in zip(self._size, rounding, strict=True)
        ]

    def _rounding(self, h: float, t: float, x: Vector, u: Vector) -> list[float]:
        """Return the rounding errors of a step: of each sum of terms, and what follows of them."""
        signs = [1.0 if i in self.sliding else s for i, s in enumerate(self.signs)]
        rates, sizes = self.program.rates(t, x, u, signs, self.parameters)
        errors = [h * ROUNDING * size for size in sizes]
        near = [value + error for value, error in zip(x, errors, strict=True)]
        near_rates, _ = self.program.rates(t, near, u, signs, self.parameters)
        return [
            error + h * abs(b - a) for error, a, b in zip(errors, rates, near_rates, strict=True)
        ]

    def _start(
        self, h: float, t: float, x: Any, u: Any, du: Any, first: bool, external: list[int]
    ) -> None:
        """Set signs at the start of a sample interval: all of them once, external ones always."""
        g, rates = self._slopes(h, t, x, u, du)
        for i in external:
            self.signs[i] = _sign(g[i]) or _sign(rates[i])
        if first:
            for i in range(len(g)):  # inner signs come first, so that outer ones see them
                g, _ = self._slopes(h, t, x, u, du)
                self.signs[i] = _sign(g[i]) or self.signs[i]
            zero = [i for i, value in enumerate(g) if value == 0.0 and i not in external]
            self._resolve(zero, h, t, x, u, du)

    def _slopes(self, h: float, t: float, x: Any, u: Any, du: Any) -> Any:
        return self.program.slopes(h, t, x, u, du, self.signs, self.parameters)

    def _interval(self, h: float, t: float, x: Any, u: Any, du: Any) -> Any:
        """Integrate over one sample interval in as many steps as it takes."""
        done, events, forced, substeps = 0.0, 0, 0, self.limits.substeps
        if not substeps and self._outgrown(x):
            self._renew(h, t, x, u)
        begun = self.n_steps
        while done < h:
            self._guard(self.n_steps - begun, forced)
            rest = h - done
            wanted = h / substeps if substeps else self.trial
            trial = rest / max(math.ceil(rest / wanted - 1e-9), 1)
            u_here = [a + done * b for a, b in zip(u, du, strict=True)]
            after, margins, error = self._try(trial, t + done, x, u_here, du)
            if not error <= 1.0 and not substeps:
                self._reject(trial, t + done, x, u_here, error)
                if trial > MIN_STEP_SHARE * h:
                    continue
                forced += 1
            if not all(map(math.isfinite, after)):
                raise Diverged("the states are not finite")
            lowest = min(margins, default=1.0)
            if lowest < 0.0 and events < MAX_EVENTS:
                events += 1
                length, x = self._event(trial, t + done, x, u_here, du)
                done = min(done + length, h)
                continue
            if not substeps:
                self._accept(trial, error, whole=trial == rest)
            x, done = after, h if trial == rest else done + trial
        return x

    def _guard(self, n_steps: int, forced: int) -> None:
        """Give up on a sample interval whose steps are too many, or too short."""
        most = self.limits.max_steps_of_sample
        if n_steps > most:
            raise TooManySteps(f"one sample interval took more than {most} steps")
        if forced > MAX_FORCED:
            raise TooShortSteps(f"{MAX_FORCED} steps of the least length had too large an error")

    def _try(self, h: float, t: float, x: Any, u: Any, du: Any) -> tuple[Any, Any, float]:
        self.n_steps += 1
        if self.n_steps > self.limits.max_steps:
            raise TooManySteps(f"it took more than max_steps={self.limits.max_steps} steps")
        try:
            after, margins, _, error = self.program.step(self.sliding)(
                h, t, x, u, du, self.signs, self._weights, self.parameters
            )
        except _FAILURES:
            return [math.nan] * len(x), [], math.nan
        return after, margins, error

    def _reject(self, h: float, t: float, x: Vector, u: Vector, error: float) -> None:
        """Shorten the next trial step, and renew the weights, which may be out of date."""
        shrink = SAFETY * error**-ORDER if math.isfinite(error) else 0.0
        self.trial = h * max(min(shrink, SAFETY), SHRINK)
        self._renew(self.trial, t, x, u)

    def _renew(self, h: float, t: float, x: Vector, u: Vector) -> None:
        with suppress(*_FAILURES):  # where the rates have no value, the step has none either
            self._weigh(h, t, x, u)

    def _outgrown(self, x: Vector) -> bool:
        """Tell whether a state is so much larger than before that steps are needlessly short."""
        return any(abs(a) > OUTGROWN * b for a, b in zip(x, self._size, strict=True))

    def _accept(self, h: float, error: float, whole: bool) -> None:
        """Set the next trial step; the cut last step of an interval cannot shorten it."""
        grown = h * min(GROW, SAFETY * max(error, 1e-10) ** -ORDER)
        self.trial = max(self.trial, grown) if whole else max(grown, h)

    def _event(self, h: float, t: float, x: Any, u: Any, du: Any) -> tuple[float, Any]:
        """Go to the first switch within the step and set the signs beyond it."""
        length, after, margins = self._locate(h, t, x, u, du)
        hit = [i for i, margin in enumerate(margins) if margin < 0.0]
        held = [i for i in hit if i not in self.sliding]
        for i in held:
            state = self._switches[i].state
            if state is not None:
                after[state] = 0.0
            if self._switches[i].external:
                self.signs[i] = -self.signs[i]
        zero = [i for i in {*hit, *self.sliding} if not self._switches[i].external]
        u_here = [a + length * b for a, b in zip(u, du, strict=True)]
        try:
            self._resolve(sorted(zero), h, t + length, after, u_here, du)
            self._release(hit)
            self._follow(hit, h, t + length, after, u_here, du)
        except _FAILURES as failure:
            raise Diverged("the right-hand side has no value") from failure
        return length, after

    def _locate(self, h: float, t: float, x: Any, u: Any, du: Any) -> tuple[float, Any, Any]:
        """Return the shortest step found with a negative margin, and its states and margins."""

        def look(length: float) -> tuple[Any, Any, float]:
            after, margins, _ = self._try(length, t, x, u, du)
            return after, margins, min(margins, default=math.nan)

        high, (after, margins, above) = h, look(h)
        low, below = 0.0, 0.0
        trial = h
        for _ in range(40):  # the margin may start at zero: find a step with a positive one
            trial *= 0.5
            found = look(trial)
            if found[2] > 0.0:
                low, below = trial, found[2]
                break
            high, (after, margins, above) = trial, found
        tolerance = EVENT_TOLERANCE * h
        side = 0
        while high - low > tolerance and below > 0.0:
            share = below / (below - above) if math.isfinite(above) else 0.5
            trial = low + min(max(share * (high - low), 0.4 * tolerance), high - low)
            trial = min(trial + 0.4 * tolerance, 0.5 * (high + trial))
            found = look(trial)
            if found[2] >= 0.0:
                low, below = trial, found[2]
                above, side = (above / 2 if side == 1 else above), 1  # Illinois rule
            else:
                high, (after, margins, above) = trial, found
                below, side = (below / 2 if side == -1 else below), -1
        return high, list(after), margins

    def _resolve(self, zero: Sequence[int], h: float, t: float, x: Any, u: Any, du: Any) -> None:
        """Apply Filippov's rule to the switches that are at zero, each given the others."""
        for _ in range(SWEEPS):
            change = 0.0
            for i in zero:
                before = self.signs[i]
                self.signs[i] = self._rule(i, before, h, t, x, u, du)
                change = max(change, abs(self.signs[i] - before))
            if change < 1e-12:
                break
        self.sliding = frozenset(i for i in zero if abs(self.signs[i]) < 1.0)

    def _rule(self, i: int, before: float, h: float, t: float, x: Any, u: Any, du: Any) -> float:
        self.signs[i] = 1.0
        up = self._slopes(h, t, x, u, du)[1][i]
        self.signs[i] = -1.0
        down = self._slopes(h, t, x, u, du)[1][i]
        if up > 0.0 and down >= 0.0:
            return 1.0
        if up <= 0.0 and down < 0.0:
            return -1.0
        if up > 0.0 > down:  # both sides push away: go on in the direction of travel
            return -_sign(before) or 1.0
        return (up + down) / (down - up) if down != up else 0.0

    def _release(self, hit: list[int]) -> None:
        """Release switches that reached their limit; rounding would hold them a little longer."""
        free = [i for i in hit if i in self.sliding and abs(self.signs[i]) > LIMIT]
        for i in free:
            self.signs[i] = _sign(self.signs[i])
        self.sliding = self.sliding.difference(free)

    def _follow(self, hit: list[int], h: float, t: float, x: Any, u: Any, du: Any) -> None:
        """Set the signs whose arguments jumped with an inner sign."""
        if len(self.signs) == len(hit):
            return
        g, _ = self._slopes(h, t, x, u, du)
        for i, value in enumerate(g):
            if i not in hit and i not in self.sliding and value:
                self.signs[i] = _sign(value)


def _rows(columns: np.ndarray) -> Iterator[tuple[float, ...]]:
    """Yield the rows of an array as tuples of plain floats."""
    return zip(*columns.T.tolist(), strict=True) if columns.shape[1] else repeat(())


def _sign(value: float) -> float:
    return float((value > 0.0) - (value < 0.0))
