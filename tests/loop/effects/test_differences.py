"""What moves relative to an input: a hull in a current, a mass on a shaken floor."""

import numpy as np
import pytest
import sympy
from loop_systems import equations_of, multisine
from scipy.signal import butter, filtfilt

import pysindy_evolve as pse
from pysindy_evolve.loop.effects.differences import acting_differences
from pysindy_evolve.loop.effects.missing import candidates
from pysindy_evolve.loop.given.ranges import Ranges
from pysindy_evolve.terms import sub, variable


def smooth(t, seed, cutoff):
    rng = np.random.default_rng(seed)
    b, a = butter(3, 2.0 * cutoff * (t[1] - t[0]))
    noise = filtfilt(b, a, rng.standard_normal(len(t)))
    return noise / noise.std()


@pytest.mark.parametrize(
    ("side", "expected"),
    [
        ("b*F - c*(v - w)", [(0, 2)]),
        ("b*F - c*v + d*w", []),
        ("b*F - 3*v + 3*w", [(0, 2)]),
        ("b*F - 3*v + 2*w", []),
        ("b*F - c*v", [(0, 2)]),
    ],
)
def test_a_difference_is_declared_or_to_an_input_that_acts_nowhere(side, expected):
    design = pse.DeclaredModel({"v": side}, inputs=["F", "w"]).design()
    assert list(acting_differences(design, 0)) == expected


@pytest.mark.parametrize("damping", ["c*(v - w)", "c*v"])
def test_drag_of_a_hull_is_found_relative_to_the_current(damping):
    t = np.arange(0.0, 150.0, 0.1)
    u = np.column_stack([1.5 * smooth(t, 0, 0.3), 0.3 + 0.2 * np.sin(t / 17.0)])
    sides = {"v": f"F - {damping.replace('c', '0.1')} - 1.1*(v - w)*abs(v - w)"}
    v = pse.simulate(equations_of(sides, ("F", "w")), [0.0], t, u)
    noise = 0.005 * np.random.default_rng(1).standard_normal(v.shape)
    record = pse.prepare(t, v + noise, u, order=1)
    declared = pse.DeclaredModel({"v": f"b*F - {damping}"}, inputs=["F", "w"])
    report = pse.close_loop(declared, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "quadratic drag"
    assert effect.coefficients == pytest.approx([-1.1], rel=0.02)
    assert str(effect.term) == "(v - w)*Abs(v - w)"


@pytest.mark.slow
def test_a_spring_to_a_shaken_floor_is_stretched_by_the_difference():
    t = np.arange(0.0, 20.0, 0.01)
    floor = 0.5 * multisine(1.0, 0)(t)
    sides = {"q": "v", "v": "-40*(q - y) - 0.8*v - 30*(q - y)**3"}
    x = pse.simulate(equations_of(sides, ("y",)), [0.0, 0.0], t, floor)
    q = x[:, 0] + 1e-3 * np.random.default_rng(1).standard_normal(len(t))
    declared = pse.DeclaredModel({"q": "v", "v": "-k*(q - y) - c*v"}, inputs=["y"])
    record = pse.prepare(t, q, floor)
    report = pse.close_loop(declared, record, operators=(), n_twins=59, random_state=0)
    (effect,) = report.effects
    assert effect.name == "cubic stiffness"
    assert effect.coefficients == pytest.approx([-30.0], rel=0.1)
    assert str(effect.term) == "(q - y)**3"


def vessels(seed, flow):
    """Levels of two tanks with a pump each, and what flows from one to the other."""
    rng, t = np.random.default_rng(seed), 2.0 * np.arange(2400.0)
    pumps = np.column_stack(
        [rng.uniform(5.0, 40.0, 60).repeat(40), rng.uniform(5.0, 30.0, 48).repeat(50)]
    )
    sides = {
        "h1": f"0.01*P1 - 0.06*sqrt(h1) - {flow}", "h2": f"0.01*P2 - 0.06*sqrt(h2) + {flow}"
    }  # fmt: skip
    model = pse.DeclaredModel(sides, inputs=["P1", "P2"])
    fine = pumps.repeat(8, axis=0)
    x = pse.simulate(model.design().equations([]), [12.0, 10.0], 0.25 * np.arange(len(fine)), fine)
    y = x[::8] + 0.03 * rng.standard_normal((len(t), 2))
    return pse.prepare(t, y, pumps, order=1, held=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flow", "term"),
    [
        ("0.04*sgn(h1 - h2)*sqrt(abs(h1 - h2))", "sqrt(Abs(h1 - h2))*sign(h1 - h2)"),
        ("0.012*(h1 - h2)*sqrt(abs(h1 - h2))", "(h1 - h2)*sqrt(Abs(h1 - h2))"),
        ("0.006*(h1 - h2)*abs(h1 - h2)", "(h1 - h2)*Abs(h1 - h2)"),
    ],
)
def test_a_flow_between_two_tanks_is_a_coupling_in_both_equations(flow, term):
    declared = pse.DeclaredModel(
        {"h1": "b*P1 - l1*sqrt(h1)", "h2": "b*P2 - l2*sqrt(h2)"}, inputs=["P1", "P2"]
    )
    report = pse.close_loop(
        declared, vessels(1, flow), vessels(2, flow), operators=(), n_twins=59, random_state=0
    )
    expected = sympy.sympify(term).subs({s: sympy.Symbol(s, real=True) for s in ("h1", "h2")})
    assert {effect.state for effect in report.effects} == {"h1", "h2"}
    for effect in report.effects:
        assert effect.name == "coupling"
        assert sympy.simplify(effect.term / expected) in (1, -1)
        assert abs(effect.coefficients[0]) == pytest.approx(
            float(flow[: flow.index("*")]), rel=0.02
        )


@pytest.mark.slow
def test_what_a_fan_carries_from_outside_is_one_coupling():
    rng, t = np.random.default_rng(0), np.arange(0.0, 200.0, 0.1)
    heat = rng.uniform(0.0, 6.0, 25).repeat(80)
    inputs = np.column_stack([heat, 5.0 + 3.0 * smooth(t, 1, 0.03), 0.5 + 0.3 * smooth(t, 2, 0.1)])
    room = {"T": "0.9*P - 0.2*(T - 15) + 0.12*w*(A - T)"}
    temperature = pse.simulate(equations_of(room, ("P", "A", "w")), [18.0], t, inputs)
    noise = 0.02 * rng.standard_normal(temperature.shape)
    declared = pse.DeclaredModel({"T": "b*P - k*(T - 15)"}, inputs=["P", "A", "w"])
    record = pse.prepare(t, temperature + noise, inputs, order=1)
    report = pse.close_loop(declared, record, operators=(), random_state=0)
    (effect,) = report.effects
    a, inside, w = sympy.symbols("A T w", real=True)
    assert effect.name == "coupling"
    assert sympy.expand(effect.term - w * (a - inside)) == 0
    assert effect.coefficients == pytest.approx([0.12], rel=0.03)


def tyre(seed):
    """Speeds of a wheel, driven by jumps of a torque, and of the vehicle that its tyre pulls."""
    rng, n, dt = np.random.default_rng(seed), 4000, 0.02
    torque = rng.uniform(-6.0, 12.0, 60).repeat(67)[:n, None]
    sides = {
        "w": "3*T - 18*tanh((w - v)/1.2) - 0.05*w", "v": "6*tanh((w - v)/1.2) - 0.02*v - 0.1"
    }  # fmt: skip
    fine = torque.repeat(8, axis=0)
    times = 0.125 * dt * np.arange(len(fine))
    x = pse.simulate(equations_of(sides, ("T",)), [20.0, 20.0], times, fine)[::8]
    y = x + 0.03 * rng.standard_normal((n, 2))
    return pse.prepare(dt * np.arange(n), y, torque, order=1, held=True)


@pytest.mark.slow
def test_a_tyre_pulls_by_no_more_than_its_grip():
    """Its slip is declared as a straight line."""
    declared = pse.DeclaredModel(
        {"w": "b*T - k1*(w - v) - c1*w", "v": "k2*(w - v) - c2*v - r"}, inputs=["T"]
    )
    report = pse.close_loop(declared, tyre(1), tyre(2), operators=(), n_twins=59, random_state=0)
    found = {effect.state: effect for effect in report.effects}
    assert set(found) == {"w", "v"}
    assert abs(found["w"].coefficients[0]) == pytest.approx(18.0, rel=0.02)
    assert abs(found["v"].coefficients[0]) == pytest.approx(6.0, rel=0.02)
    for effect in report.effects:
        assert effect.numbers["difference where it levels off"] == pytest.approx(1.2, rel=0.03)
    assert max(report.after.simulation_error) < 0.05 * max(report.before.simulation_error)


def offered(equations, inputs, ranges):
    """Return what the couplings of the first equation are called, with these ranges."""
    design = pse.DeclaredModel(equations, inputs=inputs).design()
    found = candidates(design, Ranges.of(np.array(ranges, dtype=float).T))
    return [str(c.terms[0].name((*design.names, "t"))) for c in found if c.state == 0]


@pytest.mark.parametrize(
    ("side", "warm", "expected"),
    [("P - h*(T - Ta)", 250.0, True), ("P - h*(T - Ta)", -9.0, False), ("P - h*T", 250.0, False)],
)
def test_what_is_warm_radiates_where_heat_is_declared_to_flow(side, warm, expected):
    ranges = [(warm, 600.0), (0.0, 50.0), (280.0, 300.0), (0.0, 9.0)]
    found = offered({"T": side}, ["P", "Ta"], ranges)
    assert ("-T^4 + Ta^4" in found) == expected


@pytest.mark.parametrize(
    ("side", "expected"),
    [
        ("a*(d - (v + 2*r)/20)", 4),
        ("a*(d - v)", 4),
        ("a*d - b*v", 0),
        ("a*(2*d - v - 2*r/V)", 4),  # v is an angle here
        ("a*(2*d - v - 2*r/V)/V", 4),
        ("a*(2*d - v - 2*r/w)", 0),  # w passes zero
        ("a*(2*d - v*r)", 0),
    ],
)
def test_a_declared_sum_may_pull_no_more_than_it_grips(side, expected):
    ranges = [(-1.0, 1.0), (-1.0, 1.0), (-0.1, 0.1), (3.0, 18.0), (-2.0, 2.0), (0.0, 9.0)]
    found = offered({"v": side, "r": "e*v - f*r"}, ["d", "V", "w"], ranges)
    assert len([name for name in found if "tanh" in name and "d" in name]) == expected


@pytest.mark.slow
def test_a_front_tyre_that_slips_is_one_force_in_two_equations():
    """A car whose front tyre grips no more than so much, pushed aside and turned by it."""
    t = 0.01 * np.arange(8000)
    steer = multisine(0.15, seed=3, band=(0.1, 1.2))(t)
    slip = "(d - (v + 1.2*r)/20)"
    rates = {
        "v": f"5*tanh(12*{slip}) - 70*(v - 1.4*r)/20 - 20*r",
        "r": f"4*tanh(12*{slip}) + 65*(v - 1.4*r)/20",
    }
    x = pse.simulate(equations_of(rates, ("d",)), [0.0, 0.0], t, steer)
    noise = 5e-3 * x.std(axis=0) * np.random.default_rng(0).standard_normal(x.shape)
    record = pse.prepare(t, x + noise, steer, order=1)
    declared = {
        "v": f"a*{slip} - b*(v - 1.4*r)/20 - 20*r",
        "r": f"e*{slip} + h*(v - 1.4*r)/20",
    }
    report = pse.close_loop(
        pse.DeclaredModel(declared, inputs=["d"]), record, n_twins=59, random_state=0
    )
    found = sorted(report.effects, key=lambda one: one.state, reverse=True)
    assert [(one.name, one.state) for one in found] == [("coupling", "v"), ("coupling", "r")]
    for one, grip in zip(found, (5.0, 4.0), strict=True):
        assert abs(one.coefficients[0]) == pytest.approx(grip, rel=0.03)
        assert list(one.numbers.values()) == pytest.approx([1.0 / 12.0], rel=0.03)


@pytest.mark.slow
def test_the_slip_of_a_tyre_may_be_over_a_speed_that_varies():
    """The speed is in the slip, and in how fast the path of the car turns."""
    t = 0.01 * np.arange(8000)
    speed = 20.0 + 6.0 * np.sin(0.3 * t)
    steer = np.column_stack([multisine(0.15, seed=3, band=(0.1, 1.2))(t), speed])
    slip = "(d - b - 1.2*r/V)"
    rates = {
        "b": f"5*tanh(12*{slip})/V - 70*(b - 1.4*r/V)/V - r",
        "r": f"4*tanh(12*{slip}) + 65*(b - 1.4*r/V)",
    }
    x = pse.simulate(equations_of(rates, ("d", "V")), [0.0, 0.0], t, steer)
    noise = 5e-3 * x.std(axis=0) * np.random.default_rng(0).standard_normal(x.shape)
    record = pse.prepare(t, x + noise, steer, order=1)
    declared = {"b": f"a*{slip}/V - c*(b - 1.4*r/V)/V - r", "r": f"e*{slip} + h*(b - 1.4*r/V)"}
    model = pse.DeclaredModel(declared, inputs=["d", "V"])
    report = pse.close_loop(model, record, n_twins=59, random_state=0)
    found = sorted(report.effects, key=lambda one: one.state)
    assert [(one.name, one.state) for one in found] == [("coupling", "b"), ("coupling", "r")]
    for one, grip in zip(found, (5.0, 4.0), strict=True):
        assert abs(one.coefficients[0]) == pytest.approx(grip, rel=0.03)
        assert list(one.numbers.values()) == pytest.approx([1.0 / 12.0], rel=0.03)


def test_surroundings_that_are_measured_but_act_nowhere_take_heat():
    design = pse.DeclaredModel({"T": "c*u"}, inputs=("u", "Ta")).design()
    offered = candidates(design, Ranges.about_zero(np.full(4, 3.0)))
    terms = [c.terms[0] for c in offered if c.name == "coupling"]
    assert sub(variable(2), variable(0)) in terms
    assert sub(variable(1), variable(0)) not in terms  # what heats it is no surroundings
