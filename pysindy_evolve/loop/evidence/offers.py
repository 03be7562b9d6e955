"""The candidates of a look: the vocabulary, and rarer effects if one of them beats all of it.

Rarer effects are those with a memory of a state, and stops near the ends of a stroke. Without them
a look at a record and its twins is faster, and a memory that explains noise in twins does not make
other effects less significant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...equations import Equations
from ...hidden_states.boucwen import BOUC_WEN
from ...hidden_states.path_states import paths_within, source_of
from ...hidden_states.wen_spring import WEN_SPRING
from ...terms import variable
from ..effects.candidate import Candidate, CandidateMaker
from ..effects.followers import followers_for, followers_of, is_sound
from ..effects.hysteresis import remembered_ways
from ..effects.stops import end_stops, is_stop
from ..fitting.unfolding import paths_of
from ..given.design import Design
from ..given.segments import Segments
from .scoring import EXTRA_LEAD_LOG, propose, quick_fit, score, sharpened, takes_energy

SETTLING = 0.125  # share of a record until the unknown start of a relaxation is forgotten


@dataclass(frozen=True)
class Offer:
    """The candidates of a look, and the pieces that they are scored on.

    Attributes
    ----------
    part : Segments
        Pieces of the training records.
    ways : tuple of Candidate
        Candidates beside the vocabulary.
    relaxes : bool
        Whether these are followers of a state, which need more proof than others.
    """

    part: Segments
    ways: tuple[Candidate, ...] = ()
    relaxes: bool = False

    def propose(self, design: Design, equations: Equations, part: Segments) -> list[Candidate]:
        """Return the candidates: the vocabulary and the other ways."""
        return [*propose(design, equations, part), *self.ways]

    @property
    def remembers(self) -> bool:
        """Whether candidates beside the vocabulary have a memory of a state."""
        return any(paths_within(way.terms) for way in self.ways)


def offer_for(
    design: Design, part: Segments, *, relaxing: bool = True, springs: bool = True
) -> Offer:
    """Return the candidates of a look.

    Parameters
    ----------
    design : Design
        The model so far.
    part : Segments
        Pieces of the training records.
    relaxing : bool
        Whether followers of a state, such as relaxations, may be candidates.
    springs : bool
        Whether springs with hysteresis may be candidates.

    Returns
    -------
    Offer
    """
    if part.by_trajectory:
        return Offer(part)
    hystereses = [] if design.algebraic else _hystereses_for(design, part, springs=springs)
    relaxes, late = [], _late(part)
    if relaxing and not part.has_gaps:  # in which a slow state is unknown
        relaxes = followers_for(design, part.records)
    relaxes = _worth_it(relaxes, design, late)
    if relaxes:  # mostly there are none, and the rest takes longer
        others = [*propose(design, quick_fit(design, late), late), *hystereses]
        if leading(relaxes, others, design, late) and not _begins_with_more(relaxes, design, part):
            return Offer(late, tuple(relaxes), relaxes=True)
    if hystereses:
        others = propose(design, quick_fit(design, part), part)
        if leading(hystereses, others, design, part):
            return Offer(part, tuple(hystereses))
    return Offer(part, tuple(_end_stops_for(design, part)))


def _hystereses_for(design: Design, part: Segments, *, springs: bool) -> list[Candidate]:
    """Return frictions and springs with hysteresis, of positions that have none yet."""
    longest = max(part.records, key=len)
    operators = BOUC_WEN, WEN_SPRING
    taken = {source_of(path) for path in paths_of(design) if path.operator in operators}
    found = []
    for state in design.open_states:
        position = design.position_of(state)
        if position is not None and variable(position) not in taken:
            found += remembered_ways(state, position, longest.x[:, position], springs=springs)
    return found


def _end_stops_for(design: Design, part: Segments) -> list[Candidate]:
    """Return the stops near the ends of a stroke, if one of them leads all other candidates.

    They act on little of a record, and would stand in for many other effects.
    """
    ranges = part.ranges
    found: list[Candidate] = []
    for state in design.velocities:
        place = design.position_of(state)
        if place is not None:
            size, center = float(ranges.largest[place]), float(ranges.middle[place])
            found += end_stops(CandidateMaker(state), variable(place), size, center)
    alone = [replace(stop, parents=()) for stop in found]
    if not leading(alone, (), design, part):
        return []
    proposed = sharpened(design, part, propose(design, quick_fit(design, part), part))
    others = [candidate for candidate in proposed if not is_stop(candidate)]
    return found if leading(sharpened(design, part, alone), others, design, part) else []


def leading(
    ways: Sequence[Candidate], others: Sequence[Candidate], design: Design, part: Segments
) -> list[Candidate]:
    """Return the candidates that do clearly better than all others, each alone."""
    scores = score(design, part, [*others, *ways], pairs=False) if ways else []
    best = max((s.value for s in scores if s.group[0] not in ways), default=0.0)
    return [s.group[0] for s in scores if s.group[0] in ways and s.value > best + EXTRA_LEAD_LOG]


def _begins_with_more(ways: Sequence[Candidate], design: Design, part: Segments) -> bool:
    """Tell whether a name explains more of whole records than relaxations do of their later part.

    A decaying swing shows most of what it lacks before the start of a relaxation is forgotten.
    """
    names = propose(design, quick_fit(design, part), part)
    whole = score(design, part, names, pairs=False)
    later = score(design, _late(part), ways, pairs=False)
    return bool(whole) and whole[0].value > later[0].value + EXTRA_LEAD_LOG


def _worth_it(ways: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return the followers of a state that gain clearly, plus the best of each kind, tuned.

    A narrow resonance between two places of the grid shows only after tuning. A kind is dropped if
    the record cannot tell its best relaxation time or frequency.
    """
    useful = [
        way
        for way in leading(ways, (), design, part)
        if not way.passive or takes_energy(way, design, part)
    ]
    longest, found = max(part.records, key=len), []
    for kind in dict.fromkeys((way.state, way.branch) for way in useful):
        of_kind = [way for way in useful if (way.state, way.branch) == kind]
        tuned = sharpened(design, part, of_kind)[len(of_kind) :]
        if all(is_sound(path, longest) for way in tuned for path in paths_within(way.terms)):
            found += [*of_kind, *tuned]
    return found


def after_settling(design: Design, part: Segments) -> Segments:
    """Return pieces with weight only where the start of a design's followers is forgotten."""
    return _late(part) if followers_of(design) else part


def _late(part: Segments) -> Segments:
    return part.after([int(SETTLING * len(record)) for record in part.records])
