"""Genetics: terms vary, nobody's random numbers are touched."""

import random
import threading

import numpy as np
import pytest
from deap import gp

from pysindy_evolve.breeding.genetics import Genetics
from pysindy_evolve.operators import Operator, resolve
from pysindy_evolve.terms import call, variable

SMOOTH = ("add", "sub", "mul", "div", "sin", "cos", "abs", "sgn")
PIECEWISE = ("add", "sub", "mul", "abs", "sgn")


def genetics(operators=PIECEWISE, seed=0, n_variables=2, max_depth=4):
    return Genetics(
        resolve(operators),
        np.ones(n_variables),
        max_depth=max_depth,
        rng=np.random.default_rng(seed),
    )


def breed(machine, n=40, generations=3):
    terms = machine.random_terms(n)
    for _ in range(generations):
        terms = machine.offspring(
            terms, np.arange(len(terms)), n, crossover_rate=0.9, mutation_rate=0.1
        )
    return terms


@pytest.mark.parametrize("operators", [PIECEWISE, SMOOTH, ("sin",), ("mul",), ("add", "tanh")])
def test_children_are_new_small_and_depend_on_data(operators):
    machine = genetics(operators)
    parents = machine.random_terms(30)
    children = machine.offspring(
        parents, np.arange(len(parents)), 30, crossover_rate=0.9, mutation_rate=0.5
    )
    assert children
    assert not set(children) & set(parents)
    assert len(set(children)) == len(children)
    for child in children:
        assert child.variables <= {0, 1}
        assert child.variables
        assert child.depth <= 4
        assert child.size <= 16


def test_terms_may_bring_operators_of_their_own():
    """Those of a declared model are varied too, whatever a search grows from."""
    machine, relu = genetics(), Operator("relu", lambda a: np.maximum(a, 0.0), 1)
    ((_, own),) = call(relu, variable(0)).parts
    children = machine.offspring([own] * 4, np.arange(4), 30, crossover_rate=0.9, mutation_rate=0.5)
    assert any("relu" in child.name(["a", "b"]) for child in children)


def test_a_sum_is_split_into_its_terms():
    for term in breed(genetics(("add", "sub", "mul")), n=60):
        assert all(n > 0 for _, n in term.factors)
        assert "+" not in term.name(["a", "b"])


def test_a_sign_stands_above_the_line_where_it_has_a_value_at_zero():
    terms = breed(genetics(("mul", "div", "sgn")), n=60)
    names = [term.name(["a", "b"]) for term in terms]
    assert [name for name in names if "sgn" in name]
    assert not [name for name in names if "/sgn" in name or "/(sgn" in name]


def test_a_wave_of_signs_is_no_mask_of_samples():
    names = [term.name(["a", "b"]) for term in breed(genetics(("mul", "sgn")), n=60)]
    assert not [name for name in names if "sgn(a)^2" in name or "sgn(b)^2" in name]


def test_the_same_seed_gives_the_same_terms():
    assert breed(genetics(seed=3)) == breed(genetics(seed=3))
    assert breed(genetics(seed=3)) != breed(genetics(seed=4))


def test_the_streams_of_the_caller_are_untouched():
    random.seed(1)
    np.random.seed(1)  # noqa: NPY002 the legacy stream is what must stay untouched
    before = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    breed(genetics(SMOOTH))
    after = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    assert before == after


def test_the_caller_drawing_numbers_meanwhile_changes_nothing():
    expected, results, stop = breed(genetics(SMOOTH)), [], threading.Event()

    def draw():
        while not stop.is_set():
            random.random()

    thread = threading.Thread(target=draw)
    thread.start()
    results.append(breed(genetics(SMOOTH)))
    stop.set()
    thread.join()
    assert results == [expected]


def test_deap_keeps_its_own_random():
    genetics()
    assert gp.random is random


def test_a_small_space_of_terms_ends_the_search_for_new_ones():
    machine = genetics(("neg",), n_variables=1)
    parents = machine.random_terms(10)
    assert 1 <= len(parents) <= 10
    children = machine.offspring(
        parents, [0.0] * len(parents), 10, crossover_rate=1.0, mutation_rate=1.0
    )
    assert not set(children) & set(parents)


def test_an_operator_of_three_arguments_is_varied():
    clip = Operator("clip3", lambda a, b, c: np.minimum(np.maximum(a, b), c), 3)
    terms = breed(genetics((clip, "mul")), n=20)
    assert any("clip3(" in term.name(["a", "b"]) for term in terms)


def test_no_wave_is_grown_within_another():
    grown = genetics(("mul", "sin", "cos", "exp")).random_terms(300)
    names = [term.name(["q", "v"]) for term in grown]
    assert any("sin(" in name for name in names)
    inner = [part for name in names for part in name.replace("exp(", "sin(").split("sin(")[1:]]
    assert not any(call in part.split(")")[0] for part in inner for call in ("sin(", "cos("))
