"""What does as well as the best, whatever the gains are."""

import numpy as np
import pytest

from pysindy_evolve.loop.evidence.plainest import as_good_as_best


@pytest.mark.parametrize(
    ("gains", "places"),
    [
        ([1.0, 2.0, 1.99], [1, 2]),
        ([1.0, np.inf], [1]),  # one leaves no error at all
        ([-np.inf, -np.inf], [0, 1]),  # the runs of all of them diverge
    ],
)
def test_gains_within_a_percent_of_the_largest_are_as_good(gains, places):
    assert as_good_as_best(gains) == places
