"""A candidate: an effect that may be missing, as columns that may enter an equation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from ...terms import ONE, Call, Product, Sum, of_term
from .names import EVOLVED

OFFSET = of_term(ONE)  # the parent of whatever has a mean
NODES_PER_NUMBER = 3  # nodes that a number inside a grown term counts as
REACH_IN_LOG = 1.2  # how far a number is tuned from the grid, in its logarithm: a factor of three


def bare(expression: Sum) -> Sum:
    """Return an expression with its last coefficient made one."""
    leading = expression.parts[-1][0]
    return Sum(tuple((c / leading, term) for c, term in expression.parts))


@dataclass(frozen=True)
class Shape:
    """Positive numbers on which terms depend nonlinearly, and how to build the terms.

    Attributes
    ----------
    values : tuple of float
        The numbers, each in the unit that its place in the terms gives it.
    builds : tuple of callable
        One for each term: maps the numbers to it.
    reach : float
        How far the logarithm of each number may be tuned to both sides (dimensionless).
    meanings : tuple of str
        What each number is, such as a half width.
    branch : int
        No tuning leads from one branch to another, such as from places below zero to those above.
    """

    values: tuple[float, ...]
    builds: tuple[Callable[..., Sum], ...]
    reach: float = REACH_IN_LOG
    meanings: tuple[str, ...] = ()
    branch: int = 0

    @property
    def terms(self) -> tuple[Sum, ...]:
        """The terms for these values."""
        return tuple(build(*self.values) for build in self.builds)

    @property
    def named(self) -> dict[str, float]:
        """The numbers by what they mean."""
        return dict(zip(self.meanings, self.values, strict=True))


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing: its name, the equation it enters, its columns.

    Attributes
    ----------
    name : str
        From the vocabulary.
    state : int
        The equation that it enters.
    terms : tuple of Sum
        Its columns, expressions of states, inputs and time. Each gets a coefficient of its own, in
        units of x_dot per unit of the column.
    parents : tuple of Sum
        Expressions that must already stand in the equation.
    shape : Shape, optional
        Numbers in the terms that lie on a grid, and are tuned once the effect is found.
    contains_parents : bool
        Whether its terms already contain its parents, as a cosine contains a constant. If it then
        explains all that they do, they are dropped.
    must_beat : tuple of str
        Names of plainer effects that it must beat by more than chance, see refinement.py.
    never_paired : bool
        Whether it is never scored in a pair: it is so flexible that any partner would seem useful,
        or there are too many of its kind.
    passive : bool
        Whether it can only take energy, so that the coefficient of its one term is negative.
    partners : tuple of Candidate
        Effects of other equations that are tuned and added with it. They have coefficients of
        their own, see partners.py.
    acts_at : tuple, optional
        Of an effect that enters as a declared force or rate does: its places, and the terms that
        act there. The same terms at the same places may be in several equations, see entries.py.
    free_nodes : int
        Nodes without a price: a declared term inside a grown one is known, and counts as one node.
    of_known_wave : bool
        Whether it is a term times a wave whose frequency stands in the model already, see
        pumped_terms.py.
    """

    name: str
    state: int
    terms: tuple[Sum, ...]
    parents: tuple[Sum, ...] = ()
    shape: Shape | None = field(default=None, compare=False)
    contains_parents: bool = field(default=False, compare=False)
    must_beat: tuple[str, ...] = field(default=(), compare=False)
    never_paired: bool = field(default=False, compare=False)
    passive: bool = field(default=False, compare=False)
    partners: tuple[Candidate, ...] = ()
    acts_at: tuple[tuple[int, ...], tuple[Sum, ...]] | None = field(default=None, compare=False)
    free_nodes: int = field(default=0, compare=False)
    of_known_wave: bool = field(default=False, compare=False)

    @property
    def is_exchange(self) -> bool:
        """Whether it changes what a term of the model depends on, instead of adding one."""
        return False

    @property
    def branch(self) -> int:
        """The branch that its numbers are tuned on; 0 without any."""
        return 0 if self.shape is None else self.shape.branch

    @property
    def variables(self) -> frozenset[int]:
        """The variables in its terms."""
        return frozenset().union(*(term.variables for term in self.terms))

    @property
    def is_straight(self) -> bool:
        """Whether it is a constant or a variable, so that nothing plainer could replace it."""
        return all(term.size == 1 for term in self.terms)

    @property
    def size(self) -> int:
        """Number of nodes of its terms that have a price.

        A number inside a grown term counts as several: it is tuned, so that forms with numbers come
        close to those that need none.
        """
        tuned = self.numbers if self.name == EVOLVED else ()
        return (
            sum(term.size for term in self.terms)
            - self.free_nodes
            + (NODES_PER_NUMBER - 1) * len(tuned)
        )

    @property
    def plainness(self) -> tuple[int, bool]:
        """Its size, and whether there is a function in it: a power of the same size is plainer."""
        products = (product for term in self.terms for _, product in term.parts)
        atoms = (atom for product in products for atom, _ in product.factors)
        return self.size, any(isinstance(atom, Call) for atom in atoms)

    @property
    def numbers(self) -> tuple[float, ...]:
        """The numbers inside the products of its terms."""
        return tuple(c for term in self.terms for _, one in term.parts for c in one.constants)

    @property
    def form(self) -> tuple[Product, ...]:
        """Its products, whatever the numbers in them."""
        return tuple(product.skeleton for term in self.terms for _, product in term.parts)

    @property
    def n_columns(self) -> int:
        """Number of columns that it adds to a design, with those of its partners."""
        return len(self.terms) + sum(partner.n_columns for partner in self.partners)

    def needing_no_offset(self) -> Candidate:
        """Return the effect as one that needs no offset beside it; other parents it still needs."""
        return replace(self, parents=tuple(one for one in self.parents if one != OFFSET))

    def at(self, values: Iterable[float]) -> Candidate:
        """Return the effect, and its partners, with other numbers in their shapes."""
        if self.shape is None:
            return self
        moved = replace(self.shape, values=tuple(values))
        partners = tuple(partner.at(moved.values) for partner in self.partners)
        return replace(self, terms=moved.terms, shape=moved, partners=partners)


@dataclass(frozen=True)
class _Rewritten:
    """Builds a term and rewrites it."""

    build: Callable[..., Sum]
    rewrite: Callable[[Sum], Sum]

    def __call__(self, *values: float) -> Sum:
        """Return the term."""
        return self.rewrite(self.build(*values))


def rewritten(candidate: Candidate, rewrite: Callable[[Sum], Sum]) -> Candidate:
    """Return a candidate, and its partners, with each expression rewritten, also when tuned."""
    terms, parents = (tuple(map(rewrite, sums)) for sums in (candidate.terms, candidate.parents))
    shape = candidate.shape
    if shape is not None:
        shape = replace(shape, builds=tuple(_Rewritten(build, rewrite) for build in shape.builds))
    partners = tuple(rewritten(partner, rewrite) for partner in candidate.partners)
    return replace(candidate, terms=terms, parents=parents, shape=shape, partners=partners)


@dataclass(frozen=True)
class CandidateMaker:
    """Makes the candidates of one equation."""

    state: int

    def __call__(
        self,
        name: str,
        *terms: Sum,
        parents: tuple[Sum, ...] = (),
        shape: Shape | None = None,
        contains_parents: bool = False,
        must_beat: tuple[str, ...] = (),
        never_paired: bool = False,
        passive: bool = False,
    ) -> Candidate:
        """Return a candidate; with a shape, its columns are built from that."""
        columns = terms if shape is None else shape.terms
        return Candidate(
            name,
            self.state,
            columns,
            parents,
            shape,
            contains_parents,
            must_beat,
            never_paired,
            passive,
        )
