"""What is on offer in a look: the vocabulary, and rarer effects where one of them beats all of it.

The rarer ones are what remembers a state, and the stops that only the ends of a stroke meet.
Each look at a record and its twins then takes no longer than it must, and what a memory could
explain of the noise does not change what other effects are worth.
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
from .scoring import LEAD, propose, quick_fit, score, sharpened, takes_energy

__all__ = ["Offer", "awaited", "leading", "offer_for"]

SETTLING = 0.125  # of a record, until a relaxation knows where it is


@dataclass(frozen=True)
class Offer:
    """What is proposed, and on which pieces it is looked for.

    Attributes
    ----------
    part : Segments
        Pieces of the training records.
    ways : tuple of Candidate
        What is on offer beside the vocabulary.
    relaxes : bool
        Whether these are relaxations, which need more proof than others.
    """

    part: Segments
    ways: tuple[Candidate, ...] = ()
    relaxes: bool = False

    def propose(self, design: Design, equations: Equations, part: Segments) -> list[Candidate]:
        """Return the vocabulary, and what is on offer beside it."""
        return [*propose(design, equations, part), *self.ways]

    @property
    def remembers(self) -> bool:
        """Whether what is on offer beside the vocabulary remembers a state."""
        return any(paths_within(way.terms) for way in self.ways)


def offer_for(
    design: Design, part: Segments, *, relaxing: bool = True, springs: bool = True
) -> Offer:
    """Return what is on offer.

    Parameters
    ----------
    design : Design
        The model so far.
    part : Segments
        Pieces of the training records.
    relaxing : bool
        Whether relaxations may be among it.
    springs : bool
        Whether springs that remember may be among it.

    Returns
    -------
    Offer
    """
    if part.by_trajectory:
        return Offer(part)
    yields = [] if design.algebraic else _hystereses_for(design, part, springs=springs)
    relaxes, late = [], _late(part)
    if relaxing and not part.has_gaps:  # over which a slow state would have to be guessed
        relaxes = followers_for(design, part.records)
    relaxes = _worth_it(relaxes, design, late)
    if relaxes:  # mostly none is, and all else takes longer
        others = [*propose(design, quick_fit(design, late), late), *yields]
        if leading(relaxes, others, design, late) and not _begins_with_more(relaxes, design, part):
            return Offer(late, tuple(relaxes), relaxes=True)
    if yields:
        others = propose(design, quick_fit(design, part), part)
        if leading(yields, others, design, part):
            return Offer(part, tuple(yields))
    return Offer(part, tuple(_end_stops_for(design, part)))


def _hystereses_for(design: Design, part: Segments, *, springs: bool) -> list[Candidate]:
    """Return the frictions and springs that remember, of positions that have none yet."""
    longest = max(part.records, key=len)
    turning = BOUC_WEN, WEN_SPRING
    taken = {source_of(path) for path in paths_of(design) if path.operator in turning}
    found = []
    for state in design.open_states:
        position = design.position_of(state)
        if position is not None and variable(position) not in taken:
            found += remembered_ways(state, position, longest.x[:, position], springs=springs)
    return found


def _end_stops_for(design: Design, part: Segments) -> list[Candidate]:
    """Return the stops that only the ends of a stroke meet, where one of them leads all else.

    They meet little of a record, and would stand in for much where nothing of the kind is there.
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
    others = [one for one in proposed if not is_stop(one)]
    return found if leading(sharpened(design, part, alone), others, design, part) else []


def leading(
    ways: Sequence[Candidate], others: Sequence[Candidate], design: Design, part: Segments
) -> list[Candidate]:
    """Return what clearly does better than all others, each by itself."""
    scores = score(design, part, [*others, *ways], pairs=False) if ways else []
    best = max((s.value for s in scores if s.group[0] not in ways), default=0.0)
    return [s.group[0] for s in scores if s.group[0] in ways and s.value > best + LEAD]


def _begins_with_more(ways: Sequence[Candidate], design: Design, part: Segments) -> bool:
    """Tell whether a name explains more of whole records than relaxations do of their later part.

    A swing that dies away shows most of what it lacks before any relaxation knows where it is.
    """
    names = propose(design, quick_fit(design, part), part)
    whole = score(design, part, names, pairs=False)
    later = score(design, _late(part), ways, pairs=False)
    return bool(whole) and whole[0].value > later[0].value + LEAD


def _worth_it(ways: Sequence[Candidate], design: Design, part: Segments) -> list[Candidate]:
    """Return the followers of a state that gain anything, plus the best of each kind tuned.

    A narrow resonance does not show between two places of the grid; and where the best relaxation
    is shorter, or the best frequency higher, than a record can tell, there is none.
    """
    able = [
        way
        for way in leading(ways, (), design, part)
        if not way.passive or takes_energy(way, design, part)
    ]
    longest, found = max(part.records, key=len), []
    for kind in dict.fromkeys((way.state, way.branch) for way in able):
        own = [way for way in able if (way.state, way.branch) == kind]
        tuned = sharpened(design, part, own)[len(own) :]
        if all(is_sound(path, longest) for way in tuned for path in paths_within(way.terms)):
            found += [*own, *tuned]
    return found


def awaited(design: Design, part: Segments) -> Segments:
    """Return pieces with weight only where what follows a state of a design knows where it is."""
    return _late(part) if followers_of(design) else part


def _late(part: Segments) -> Segments:
    return part.after([int(SETTLING * len(record)) for record in part.records])
