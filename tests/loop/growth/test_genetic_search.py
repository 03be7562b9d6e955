"""Which operators the search of the loop grows terms from."""

from pysindy_evolve.loop.growth.genetic_search import OPERATORS, _without_quotients
from pysindy_evolve.operators import resolve


def test_a_search_divides_only_where_there_are_sums_to_divide_by():
    plain = [operator.name for operator in _without_quotients(resolve(OPERATORS))]
    assert "div" in OPERATORS
    assert plain == [name for name in OPERATORS if name != "div"]
    rational = resolve(("add", "mul", "div"))
    assert _without_quotients(rational) == list(rational)
