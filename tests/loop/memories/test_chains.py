"""A delay and a lag one after the other: whichever is found first gives way to the other one."""

from dataclasses import replace

import numpy as np
import pytest
from test_memory import close, record_with

import pysindy_evolve as pse
from pysindy_evolve.hidden_states.memory import Memory
from pysindy_evolve.loop.memories import length_and_kind
from pysindy_evolve.loop.memories.chains import Chain, Traded, with_trade, with_trades_done

T = np.arange(0.0, 20.0, 0.01)
WAVE = np.sin(3 * T) + 0.5 * np.sin(7 * T + 1.0)
DELAY, LAG = Memory("input delay", 0, (0.3,)), Memory("actuator lag", 0, (0.4,))
INNER = slice(300, -100)


@pytest.mark.parametrize(
    ("present", "new", "left"),
    [
        (DELAY, Traded("actuator lag", 0, (0.15,), 0.3, 0.1), (0.2, 0.15)),
        (LAG, Traded("input delay", 0, (0.15,), 0.4, 0.1), (0.15, 0.3)),
    ],
)
def test_what_is_present_gives_way(present, new, left):
    acts = new.response(T, present.response(T, WAVE))
    expected = Chain("actuator lag", 0, left).response(T, WAVE)
    assert acts[INNER] == pytest.approx(expected[INNER], abs=2e-4)


def test_only_a_longer_memory_of_the_other_kind_gives_way():
    short, longer = Memory("actuator lag", 0, (0.1,)), Memory("actuator lag", 0, (0.5,))
    assert with_trade(short, [DELAY]) == Traded("actuator lag", 0, (0.1,), 0.3, 0.1)
    assert with_trade(longer, [DELAY]) is longer
    assert with_trade(short, [LAG]) is short
    assert with_trade(short, [Memory("input delay", 1, (0.3,))]) is short
    assert with_trades_done([]) == []


def test_nothing_gives_way_by_more_than_there_is_of_it(monkeypatch):
    """Then it changes nothing, which may be the least that a search finds."""
    monkeypatch.setattr(length_and_kind, "_least", lambda loss, start: (0.1, 0.299))
    began = Traded("actuator lag", 0, (0.1,), 0.3, 0.1)
    assert not replace(began, given=0.299).leaves_some
    assert length_and_kind.trade_of(began, None, None) is began


@pytest.mark.slow
@pytest.mark.parametrize("values", [(0.05, 0.03), (0.02, 0.06)])
def test_a_delay_and_a_lag_of_one_input_are_both_found(values):
    report = close(record_with(Chain("actuator lag", 0, values)))
    found = {effect.name: effect.coefficients[0] for effect in report.effects}
    assert found == {
        "input delay": pytest.approx(values[0], rel=0.05),
        "actuator lag": pytest.approx(values[1], rel=0.05),
    }
    assert report.after.simulation_error[0] < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("memory", [Memory("input delay", 0, (0.05,)), LAG])
def test_one_memory_stays_alone(memory):
    report = close(record_with(memory))
    assert [effect.name for effect in report.effects] == [memory.kind]


def heated(seed):
    """Measure a temperature that follows a heater with levels 17 s late, each 5 s: t, T, P."""
    rng = np.random.default_rng(seed)
    ends = np.cumsum(150.0 * rng.uniform(0.6, 1.4, 5000))
    levels = rng.uniform(0.0, 100.0, 5000)
    t, fine = np.arange(0.0, 8000.0, 5.0), np.arange(0.0, 8000.0, 0.1)
    power = levels[np.searchsorted(ends, t, side="right")]
    late = np.repeat(power, 50)[np.maximum(np.arange(len(fine)) - 170, 0)]
    rest, temperature = 20.0 + 0.02 / 0.012 * late, [70.0]
    for level in rest[:-1]:
        temperature.append(level + (temperature[-1] - level) * np.exp(-0.012 * 0.1))
    noise = 0.5 * np.random.default_rng(seed).standard_normal(len(t))
    return t, np.array(temperature)[::50] + noise, power


@pytest.mark.slow
def test_a_lag_that_runs_show_beside_a_delay_takes_its_part_of_it():
    """The delay was reported whole beside the lag, and the equation was not what the runs were."""
    t, temperature, power = heated(0)
    train, test = (
        pse.prepare(t[part], temperature[part], power[part], order=1)
        for part in (slice(1120), slice(1120, None))
    )
    model = pse.DeclaredModel({"T": "a*P - h*(T - 20)"}, inputs=["P"])
    report = pse.close_loop(model, train, test=test, random_state=0)
    assert not any(isinstance(memory, Traded) for memory in report.equations.memories)
    assert sum(effect.coefficients[0] for effect in report.effects) == pytest.approx(17.0, rel=0.02)
