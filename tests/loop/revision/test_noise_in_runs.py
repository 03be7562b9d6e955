"""A function of an input that only takes the noise of its sensor off free runs is no effect."""

import numpy as np
import pytest

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.effects.names import EVOLVED
from pysindy_evolve.loop.evidence.findings import Finding
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.loop.revision.noise_in_runs import without_noise_in_runs
from pysindy_evolve.operators import BUILTIN
from pysindy_evolve.terms import call, mul, variable

DT = 0.001
DECLARED = pse.DeclaredModel({"x": "v", "v": "b*F - k*x - c*v"}, inputs=["F"])
FORCE = variable(2)
ABS, TANH = call(BUILTIN["abs"], FORCE), call(BUILTIN["tanh"], FORCE)


def struck(seed, noise, bent):
    """A mode of a beam that a hammer strikes four times; its gauge is noisy, mm and N."""
    rng, t = np.random.default_rng(seed), DT * np.arange(3000)
    since = t[:, None] - np.sort(rng.uniform(0.05, 2.6, 4))
    blows = np.sin(np.pi * since / 0.012) ** 2 * ((since > 0) & (since < 0.012))
    force = blows @ (60.0 * rng.uniform(0.5, 1.3, 4) * rng.choice([-1.0, 1.0], 4))
    sides = {"x": "v", "v": f"1000*F + {bent}*F*abs(F) - 5700*x - 2.4*v"}
    truth = pse.DeclaredModel(sides, inputs=["F"]).design().equations([])
    x = pse.simulate(truth, [0.0, 0.0], t, force)[:, 0]
    y = x + 0.003 * x.std() * rng.standard_normal(len(t))
    return pse.prepare(t, y, force + noise * rng.standard_normal(len(t)))


def found(term):
    candidate, design = Candidate(EVOLVED, 1, (term,)), DECLARED.design()
    return Finding(candidate, columns_of(candidate, design), 1.0, 0.001, np.zeros(999))


@pytest.mark.parametrize(
    ("term", "bent", "is_kept"), [(mul(TANH, ABS), 0.0, False), (mul(FORCE, ABS), 5.0, True)]
)
def test_noise_between_the_blows_of_a_hammer_is_no_effect(term, bent, is_kept):
    records, finding = [struck(seed, 0.1, bent) for seed in range(3)], found(term)
    rng = np.random.default_rng(0)
    kept = without_noise_in_runs(DECLARED.design(), [finding], records, rng)
    assert kept == ([finding] if is_kept else [])
