"""Pairs of effects: those that bring what the other needs, and one force in two equations."""

from dataclasses import replace

from pysindy_evolve.loop.effects.candidate import OFFSET, Candidate
from pysindy_evolve.loop.effects.names import EVOLVED
from pysindy_evolve.loop.evidence.pairing import groups_to_try, posing_as_offset
from pysindy_evolve.terms import variable

X, Y, Z = (variable(k) for k in range(3))


def tried(*offered, present=frozenset()):
    return groups_to_try(offered, range(len(offered)), set(present), pairs=True)


def test_all_are_tried_alone_and_in_pairs():
    one, two = Candidate("one", 0, (X,)), Candidate("two", 0, (Y,))
    assert tried(one, two) == [(0,), (1,), (0, 1)]
    assert groups_to_try([one, two], [0, 1], set(), pairs=False) == [(0,), (1,)]


def test_what_needs_a_parent_comes_with_it_or_not_at_all():
    parent, child, other = (
        Candidate("parent", 0, (X,)), Candidate("child", 0, (Y,), parents=(X,)),
        Candidate("other", 0, (Z,)),
    )  # fmt: skip
    assert tried(parent, child, other) == [(0,), (2,), (0, 1), (0, 2)]
    assert (1,) in tried(parent, child, other, present={(0, X)})
    assert (1,) not in tried(parent, child, other, present={(1, X)})


def test_two_shapes_of_one_name_are_no_pair_unless_they_grew():
    for name, pairs in (("drag", []), (EVOLVED, [(0, 1)])):
        assert tried(Candidate(name, 0, (X,)), Candidate(name, 0, (Y,)))[2:] == pairs


def test_one_force_in_two_equations_is_a_pair_though_each_is_scored_in_no_other():
    friction, offset = (0, (X,)), (0, (OFFSET,))
    offered = [
        Candidate("friction", state, (term,), never_paired=True, acts_at=force)
        for state, term, force in (
            (0, X, friction), (1, Y, friction), (0, Z, offset), (0, Y, friction)
        )
    ]  # fmt: skip
    assert tried(*offered)[4:] == [(0, 1), (1, 3)]
    squares = [replace(one, parents=(Z,)) for one in offered]
    assert tried(*squares) == [(2,)]  # which brings what it needs itself


def test_an_offset_is_posed_as_only_where_there_is_none():
    offered = [Candidate("offset", 0, (OFFSET,)), Candidate("square", 0, (X,), parents=(OFFSET,))]
    assert posing_as_offset(offered, [0, 1], set()) == [(0, 1)]
    assert posing_as_offset(offered, [0, 1], {(0, OFFSET)}) == []


def test_a_varying_term_poses_as_an_offset_once_the_term_itself_stands():
    """A stiffness that varies along a belt was never tried, as no offset stood in the equation."""
    varying = Candidate("varying", 0, (X,), parents=(OFFSET, Y), never_paired=True)
    offered = [Candidate("offset", 0, (OFFSET,)), varying]
    assert posing_as_offset(offered, [0, 1], {(0, Y)}) == [(0, 1)]
    assert posing_as_offset(offered, [0, 1], set()) == []
