"""When a search ends: nothing new for long, nothing left, or nothing but noise left."""

import numpy as np
import pytest

from pysindy_evolve.breeding.dictionary import Problem
from pysindy_evolve.breeding.generation import Generation
from pysindy_evolve.breeding.plateau import Plateau, share_common_to_neighbors
from pysindy_evolve.terms import Product, Variable

Q, V = (Product(((Variable(i), 1),)) for i in range(2))


@pytest.fixture
def walk():
    rng = np.random.default_rng(0)
    return rng.uniform(-1, 1, size=(20_000, 2)), rng.normal(size=20_000)


def problem(x, y):
    return Problem(x, y, np.empty((len(x), 0)))


def generation(*terms, error=0.1):
    return Generation(1, terms, (1.0,) * len(terms), error, 0.0)


def lasts(plateau, *found):
    """Count the generations until the search ends; the last one is repeated."""
    for number in range(1, 20):
        if plateau.reached(found[min(number, len(found)) - 1]):
            return number
    return None


def test_a_search_that_leaves_noise_ends_after_two_stale_generations(walk):
    x, noise = walk
    assert lasts(Plateau(problem(x, 9 * x[:, 0] + 0.5 * noise), 10), generation(Q)) == 3


def test_a_search_that_leaves_structure_goes_on_until_its_patience_ends(walk):
    x, noise = walk
    y = 9 * x[:, 0] + 0.2 * x[:, 1] + 0.5 * noise  # a twentieth of the residual's power
    assert lasts(Plateau(problem(x, y), 10), generation(Q)) == 11


def test_few_rows_cannot_say_that_noise_is_left(walk):
    x, noise = walk
    y = 9 * x[:1000, 0] + 0.5 * noise[:1000]
    assert lasts(Plateau(problem(x[:1000], y), 10), generation(Q)) == 11


def test_neighbors_that_are_too_far_to_judge_do_not(walk):
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, size=(20_000, 20))
    y = 9 * x[:, 0] + 0.5 * walk[1]
    assert lasts(Plateau(problem(x, y), 10), generation(Q)) == 11


def test_an_equation_that_comes_and_goes_is_no_news(walk):
    x, noise = walk
    y = 9 * x[:, 0] + 0.2 * x[:, 1] + 0.5 * x[:, 0] * x[:, 1] + 0.5 * noise
    plateau = Plateau(problem(x, y), 5)
    found = [generation(Q, V), *[generation(Q), generation(Q, V)] * 5]
    assert lasts(plateau, *found) == 6


def test_a_perfect_equation_of_one_variable_ends_the_search_at_once(walk):
    x, _ = walk
    assert lasts(Plateau(problem(x, x[:, 0]), 10), generation(Q, error=0.0)) == 1


def test_a_perfect_equation_of_more_waits_for_a_shorter_one(walk):
    x, _ = walk
    assert lasts(Plateau(problem(x, x[:, 0]), 10), generation(Q, V, error=0.0)) == 3


def test_likeness_is_the_share_of_power_that_is_a_function_of_place():
    rng = np.random.default_rng(0)
    neighbors = (np.arange(5000)[:, None] + [1, 2]) % 5000
    smooth = np.sin(np.arange(5000) * 2 * np.pi / 5000)
    noise = rng.normal(size=5000) * (1 + np.abs(smooth))
    assert share_common_to_neighbors(smooth, neighbors)[0] == pytest.approx(1.0, abs=1e-4)
    share, error = share_common_to_neighbors(noise, neighbors)
    assert abs(share) < 3 * error
    assert error == pytest.approx(1 / np.sqrt(5000), rel=0.3)
    assert share_common_to_neighbors(np.zeros(5000), neighbors) == (0.0, 0.0)
