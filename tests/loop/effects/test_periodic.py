"""Forcing and ripple: which lines of a residual are proposed, and which are not its own."""

from dataclasses import replace

import numpy as np
import pytest
from loop_systems import equations_of, multisine

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.candidate import Candidate
from pysindy_evolve.loop.effects.modulation import pumping
from pysindy_evolve.loop.effects.names import FORCING
from pysindy_evolve.loop.effects.partners import apart
from pysindy_evolve.loop.effects.periodic import (
    Signal,
    other_ripples,
    periodic_candidates,
    ripple_candidates,
    waves_of,
)
from pysindy_evolve.loop.effects.pumped_terms import (
    is_partner_pump,
    other_pumps,
    partner_pumps,
    shared_pumps,
)
from pysindy_evolve.loop.evidence.scoring import columns_of
from pysindy_evolve.terms import mul, variable

N_TIMES_P = mul(variable(0), variable(1))
STILL = np.empty((1000, 0))  # no inputs


@pytest.mark.parametrize("omega", [2.7, 11.3, 40.0])
def test_frequency_of_a_periodic_residual_is_proposed_within_a_percent(omega):
    t = np.arange(0.0, 20.0, 0.02)
    noise = 0.5 * np.random.default_rng(0).standard_normal(len(t))
    residual = 3.0 + np.cos(omega * t + 0.3) + noise
    first, *_ = periodic_candidates(1, 3, Signal(residual, STILL, 0.02))
    assert first.name == "periodic forcing"
    assert first.state == 1
    assert first.terms[0].constants[0] == pytest.approx(omega, rel=0.01)
    z = np.column_stack([np.zeros((len(t), 3)), t])
    sine, cosine = (term.evaluate(z) for term in first.terms)
    assert sine**2 + cosine**2 == pytest.approx(1.0)


def test_a_forcing_may_be_tuned_by_what_the_record_resolves_and_tells_its_frequency():
    t = np.arange(0.0, 20.0, 0.02)
    residual = np.cos(11.3 * t) + 0.5 * np.cos(23.0 * t)
    one, other = (c.shape for c in periodic_candidates(1, 3, Signal(residual, STILL, 0.02)))
    assert list(one.named) == ["angular frequency"]
    assert one.reach == pytest.approx(0.5 * 2.0 * np.pi / (11.3 * 20.0), rel=0.01)
    assert one.branch != other.branch


def test_line_of_the_input_is_no_forcing_of_its_own():
    t = np.arange(0.0, 20.0, 0.02)
    rng = np.random.default_rng(0)
    residual = np.cos(7.0 * t) + 0.5 * np.sin(19.0 * t) + 0.1 * rng.standard_normal(len(t))
    force = 3.0 * np.sin(7.0 * t + 0.2)[:, None]
    (found,) = periodic_candidates(0, 1, Signal(residual, force, 0.02))
    assert found.terms[0].constants[0] == pytest.approx(19.0, rel=0.01)


@pytest.mark.parametrize("seed", range(5))
def test_a_response_to_an_input_of_many_lines_is_no_forcing_either(seed):
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 28.0, 0.02)
    frequencies = np.linspace(0.3, 4.0, 30) + rng.uniform(-0.02, 0.02, 30)
    waves = np.sin(2 * np.pi * np.outer(t, frequencies) + rng.uniform(0.0, 6.0, 30))
    slow = waves @ (0.2 / (1.0 + (frequencies / 0.5) ** 2))  # what a model gets wrong at low ones
    residual = slow + 0.002 * rng.standard_normal(len(t))
    force = waves.sum(axis=1)[:, None]
    assert periodic_candidates(0, 1, Signal(residual, STILL, 0.02)) != []
    assert periodic_candidates(0, 1, Signal(residual, force, 0.02)) == []
    omega = np.pi * (frequencies[3] + frequencies[4])  # midway between two of them
    found = periodic_candidates(0, 1, Signal(residual + 0.2 * np.sin(omega * t), force, 0.02))
    assert found[0].terms[0].constants[0] == pytest.approx(omega, rel=0.01)


@pytest.mark.parametrize("seed", range(3))
def test_a_resonance_that_a_dense_input_drives_is_no_forcing(seed):
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, 0.01)
    frequencies = np.linspace(0.5, 12.0, 40)  # six places of the spectrum apart, all alike
    phases = rng.uniform(0.0, 6.0, 40)
    sharp = 1.0 / (1.0 - (frequencies / 4.9) ** 2 + 0.1j * frequencies / 4.9)
    waves = np.exp(1j * (2 * np.pi * np.outer(t, frequencies) + phases))
    residual = (waves @ sharp).imag + 2.0 * rng.standard_normal(len(t))
    assert periodic_candidates(0, 1, Signal(residual, STILL, 0.01)) != []
    assert periodic_candidates(0, 1, Signal(residual, waves.imag.sum(axis=1)[:, None], 0.01)) == []


def test_line_beside_one_of_the_input_is_a_forcing():
    t = np.arange(0.0, 40.0, 0.02)
    apart = 2 * np.pi * 1.7 / 40.0  # nearer than the two skirts are wide, but another frequency
    noise = 0.1 * np.random.default_rng(0).standard_normal(len(t))
    force = 3.0 * np.sin(7.0 * t + 0.2)[:, None]
    (found,) = periodic_candidates(0, 1, Signal(np.cos((7.0 + apart) * t) + noise, force, 0.02))
    assert found.terms[0].constants[0] == pytest.approx(7.0 + apart, rel=0.003)


@pytest.mark.parametrize("seed", range(5))
def test_noise_has_no_line(seed):
    noise = np.random.default_rng(seed).standard_normal(1000)
    assert periodic_candidates(0, 1, Signal(noise, STILL, 0.02)) == []


def test_two_frequencies_are_both_proposed():
    t = np.arange(0.0, 20.0, 0.02)
    residual = np.cos(7.0 * t) + 0.5 * np.sin(19.0 * t)
    found = periodic_candidates(0, 1, Signal(residual, STILL, 0.02))
    assert sorted(c.terms[0].constants[0] for c in found) == pytest.approx([7.0, 19.0], rel=0.01)


@pytest.mark.parametrize("residual", [np.zeros(200), np.ones(200), np.zeros(5)])
def test_residual_without_any_frequency_proposes_none(residual):
    assert periodic_candidates(0, 1, Signal(residual, STILL, 0.02)) == []


def test_slow_drift_is_no_periodic_forcing():
    t = np.arange(0.0, 20.0, 0.02)
    for candidate in periodic_candidates(0, 1, Signal(0.3 * t, STILL, 0.02)):
        periods = candidate.terms[0].constants[0] * t[-1] / (2 * np.pi)
        assert periods > 2.5


@pytest.fixture
def travel():
    """A position that goes to and fro within a stroke of two, never twice at the same pace."""
    t = np.arange(0.0, 40.0, 0.01)
    return np.sin(0.9 * t) * np.cos(0.13 * t), np.random.default_rng(0).standard_normal(len(t))


@pytest.mark.parametrize("wave_number", [15.0, 50.0, 200.0])
def test_wave_number_of_a_ripple_is_proposed_within_a_percent(travel, wave_number):
    q, noise = travel
    (ripple,) = ripple_candidates(1, 0, np.cos(wave_number * q + 0.3) + noise, q)
    assert ripple.name == "position-periodic ripple"
    assert ripple.terms[0].constants[0] == pytest.approx(wave_number, rel=0.01)
    assert ripple.terms[0].variables == {0}


@pytest.mark.parametrize("power", [0, 1, 2, 3])
def test_noise_and_springs_are_no_ripple(travel, power):
    q, noise = travel
    assert ripple_candidates(1, 0, q**power + 0.3 * noise, q) == []


@pytest.mark.parametrize("q", [np.zeros(500), np.linspace(0.0, 1.0, 40)])
def test_a_position_that_rests_or_has_few_samples_has_no_ripple(q):
    assert ripple_candidates(1, 0, np.sin(40.0 * q), q) == []


def test_a_wave_number_may_be_tuned_by_half_a_period_of_the_stroke_and_no_further(travel):
    q, noise = travel
    (ripple,) = ripple_candidates(1, 0, np.cos(50.0 * q) + noise, q)
    assert ripple.shape.reach == pytest.approx(0.5 / (50.0 * np.ptp(q) / (2 * np.pi)), rel=0.02)


@pytest.mark.parametrize("known", [{}, {"k": 9000.0}])
def test_a_ripple_of_a_geared_load_may_repeat_with_the_angle_of_its_motor(travel, known):
    """Twenty turns of the motor for one of the load, counted from another zero in each record."""
    equations = {"p": "w", "w": "k*(a/20 - p) - c*w + e*M", "a": "v", "v": "b*M - e*v"}
    design = pse.DeclaredModel(equations, inputs=["M"], known=known).design()
    q, noise = travel
    (ripple,) = ripple_candidates(1, 0, np.sin(40.0 * q), q)
    rest = np.zeros_like(q)
    rows = np.column_stack([q, rest, -20.0 * q, rest, noise, rest])
    pieces = rows.reshape(2, -1, 6) + np.array([[[0.0, 0, 0, 0, 0, 0]], [[0.0, 0, 90.0, 0, 0, 0]]])
    (other,) = other_ripples(ripple, design, pieces)
    assert (other.name, other.state, other.variables) == (ripple.name, 1, {2})
    assert other.shape.values == pytest.approx((ripple.shape.values[0] / 20.0,), rel=1e-6)
    assert other.terms == tuple(build(*other.shape.values) for build in waves_of(2))
    assert other_ripples(other, design, pieces) == []  # it is over another body's angle already
    pieces[:, :, 2] = 0.0  # the motor stands still
    assert other_ripples(ripple, design, pieces) == []


def test_a_ripple_as_fine_as_the_steps_of_an_encoder_is_none_of_the_machine(travel):
    q, noise = travel
    step = 2 * np.pi / 200.0
    residual = np.cos(200.0 * q) + noise
    assert ripple_candidates(1, 0, residual, q, noise=step / np.sqrt(12)) == []
    assert len(ripple_candidates(1, 0, residual, q, noise=step / 20)) == 1


@pytest.mark.parametrize("periods", [3.3, 3.5, 3.7])
def test_what_is_too_slow_for_a_ripple_is_none_of_any_other_wave_number(periods):
    q = np.linspace(0.0, 1.0, 2000)
    noise = 0.05 * np.random.default_rng(0).standard_normal(2000)
    for ripple in ripple_candidates(1, 0, np.sin(2.0 * np.pi * periods * q) + noise, q):
        assert 3.9 < ripple.shape.values[0] / (2.0 * np.pi) < 6.0
        assert ripple.shape.reach > 0.0


def test_a_stiffness_that_is_pumped_is_found_with_its_frequency():
    t = np.arange(0.0, 30.0, 0.01)
    force = multisine(20.0, 0)(t)
    sides = {"q": "v", "v": "-150*q - 0.8*v + F - 30*q*cos(9.1*t)"}
    x = pse.simulate(equations_of(sides, ("F",)), [0.0, 0.0], t, force)
    q = x[:, 0] + 1e-3 * x[:, 0].std() * np.random.default_rng(0).standard_normal(len(t))
    declared = pse.DeclaredModel({"q": "v", "v": "-k*q - c*v + b*F"}, inputs=["F"])
    report = pse.close_loop(
        declared, pse.prepare(t, q, force), operators=(), n_twins=59, random_state=0
    )
    (effect,) = report.effects
    assert effect.name == "periodic forcing"
    frequencies = {
        number for product in effect.expressions for number in product.parts[0][1].constants
    }
    assert sorted(frequencies) == pytest.approx([9.1], rel=1e-3)
    assert np.abs(effect.coefficients).max() == pytest.approx(30.0, rel=0.02)


def test_a_signal_without_a_value_somewhere_has_no_lines():
    t = np.arange(1000)
    signal, driver = np.sin(0.3 * t), np.cos(0.05 * t)[:, None]
    assert Signal(signal, driver, 1.0).lines()
    signal[500] = np.nan
    assert Signal(signal, driver, 1.0).lines() == []


T = np.arange(1500) * 0.02


def test_what_pumps_a_population_that_has_its_line_is_found_all_the_same():
    """It grows and falls with the pump, so that its own spectrum has the same line."""
    values = np.exp(2.0 * np.sin(2.0 * np.pi * T + 1.0) + 0.6 * np.sin(2.0 * np.pi * 0.31 * T))
    noise = 0.01 * values.std() * np.random.default_rng(0).standard_normal(len(T))
    residual = 0.1 * values * np.cos(2.0 * np.pi * T + 0.3) + noise
    (found,) = pumping(residual - 0.04 * values, values, 8)
    assert found / 0.02 == pytest.approx(1.0, rel=1e-3)


def test_a_forcing_may_be_a_term_that_is_pumped_at_its_frequency():
    design = pse.DeclaredModel({"N": "r*N - a*N*P", "P": "b*N*P - m*P*t"}).design()
    wave, *_ = periodic_candidates(0, 2, Signal(np.cos(7.0 * T), np.empty((len(T), 0)), 0.02))
    plain, *pumped = other_pumps(wave, design)
    product = mul(variable(0), variable(1))
    assert plain == wave
    assert [one.parents for one in pumped] == [(variable(0),), (product,)]
    assert pumped[1].terms == tuple(mul(product, term) for term in wave.terms)
    assert other_pumps(Candidate("coupling", 0, (product,)), design) == []


def test_what_is_pumped_in_one_equation_may_be_in_another():
    design = pse.DeclaredModel({"N": "r*N - a*N*P", "P": "b*N*P - m*P*t"}).design()
    assert partner_pumps(design, 30.0) == []
    wave, *_ = periodic_candidates(0, 2, Signal(np.cos(7.0 * T), np.empty((len(T), 0)), 0.02))
    with_it = design.adding(columns_of(wave, design))
    found = [(one.state, *one.parents) for one in partner_pumps(with_it, 30.0)]
    product = mul(variable(0), variable(1))
    assert found == [(0, variable(0)), (0, product), (1, product)]
    partners = partner_pumps(with_it, 30.0)
    added = with_it.columns[len(design.columns) :]
    assert [is_partner_pump(one, added, 2) for one in partners] == [False, False, True]
    assert not any(is_partner_pump(one, (), 2) for one in partners)  # the wave was declared
    assert not is_partner_pump(wave, added, 2)


@pytest.mark.parametrize(("gained", "is_shared"), [("a", True), ("b", False)])
def test_a_pumped_term_is_offered_in_all_equations_of_its_coefficient(gained, is_shared):
    design = pse.DeclaredModel({"N": "r*N - a*N*P", "P": f"{gained}*N*P - m*P"}).design()
    wave, *_ = periodic_candidates(0, 2, Signal(np.cos(7.0 * T), np.empty((len(T), 0)), 0.02))
    offered = other_pumps(wave, design)
    shared = [apart(one) for one in shared_pumps(design, offered)]
    assert [[one.state for one in both] for both in shared] == ([[0, 1]] if is_shared else [])
    for here, there in shared:
        assert here in [replace(one, parents=(), never_paired=True) for one in offered]
        assert here.terms == there.terms == tuple(mul(N_TIMES_P, term) for term in wave.terms)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_pumped_population_is_told_from_one_that_is_stocked(seed):
    """It swings with the pump near its own period, so each of its terms has a line there."""
    sides = {"N": "N - N**2/12 - 0.4*N*P*(1 + 0.2*cos(1.2*t))", "P": "0.2*N*P - 0.5*P"}
    model, rng = pse.DeclaredModel(sides), np.random.default_rng(seed)
    t = np.arange(0.0, 120.0, 0.1)

    def measured():
        x = pse.simulate(equations_of(sides), rng.uniform([1.0, 0.5], [5.0, 2.0]), t)
        noisy = x * (1.0 + 0.003 * rng.standard_normal(x.shape))
        return pse.prepare(t, noisy, order=1)

    model = pse.DeclaredModel({"N": "r*N - s*N**2 - a*N*P", "P": "b*N*P - m*P"})
    report = pse.close_loop(model, measured(), measured(), operators=(), random_state=0)
    (effect,) = report.effects
    assert effect.name == FORCING
    assert all(term.variables == {0, 1, 2} for term in effect.expressions)
    assert report.after.simulation_error.max() < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_rate_that_is_pumped_is_found_in_both_its_equations_at_once(seed):
    """A wave in one of them alone bends the rate in the other, and other terms took its place."""
    flow = "100*(1 + 0.06*cos(2*pi*t))*S*I"
    truth = {"S": f"0.25*(1 - S) - {flow}", "I": f"{flow} - 25.25*I"}
    rng = np.random.default_rng(seed)

    def measured(start, end):
        t = np.arange(0.0, end, 1.0 / 52.0)
        x = pse.simulate(equations_of(truth), start, t)
        return pse.prepare(t, x + 0.005 * x.std(axis=0) * rng.standard_normal(x.shape), order=1)

    model = pse.DeclaredModel({"S": "m*(1 - S) - b*S*I", "I": "b*S*I - g*I"})
    train, test = measured([0.27, 0.005], 25.0), measured([0.24, 0.012], 12.0)
    report = pse.close_loop(model, train, test, operators=(), n_twins=59, random_state=0)
    assert sorted((effect.state, effect.name) for effect in report.effects) == [
        ("I", FORCING),
        ("S", FORCING),
    ]
    for effect in report.effects:
        assert np.hypot(*effect.coefficients) == pytest.approx(6.0, rel=0.03)
    assert np.max(report.after.simulation_error) < 2.0


@pytest.mark.slow
def test_what_is_pumped_is_found_where_it_leaves_and_where_it_enters():
    """Of those who may fall ill the pump moves hardly any, of the ill ones many."""
    flow = "3.5*(1 + 0.12*cos(2*pi*t/52 + 0.4))*S*I"
    sides = {"S": f"0.0006*(1 - S) + 0.004*(1 - S - I) - {flow}", "I": f"{flow} - 0.5*I"}
    rng, t = np.random.default_rng(0), np.arange(0.0, 700.0, 0.25)
    x = pse.simulate(pse.DeclaredModel(sides).design().equations([]), [0.16, 0.004], t)
    record = pse.prepare(t, x + 0.005 * x.std(axis=0) * rng.standard_normal(x.shape), order=1)
    model = pse.DeclaredModel({"S": "m*(1 - S) - w*I - k*S*I", "I": "k*S*I - g*I"})
    report = pse.close_loop(model, record, operators=(), random_state=0)
    pumped = {effect.state: effect for effect in report.effects}
    assert sorted(pumped) == ["I", "S"]
    for effect in pumped.values():
        assert effect.name == FORCING
        assert np.hypot(*effect.coefficients) == pytest.approx(0.42, rel=0.05)
        assert all(term.variables == {0, 1, 2} for term in effect.expressions)


@pytest.mark.parametrize("seed", range(3))
def test_noise_is_pumped_by_nothing(seed):
    values, residual = np.random.default_rng(seed).standard_normal((2, len(T)))
    assert pumping(residual, 2.0 + values, 8) == []
    assert pumping(np.full(len(T), np.nan), values, 8) == []
