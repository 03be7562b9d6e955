"""What acts along a motion in a plane is found in each of its coordinates, as one force."""

import numpy as np
import pytest
from loop_systems import equations_of

import pysindy_evolve as pse

SPEED = "sqrt(vx**2 + vy**2)"


def throws(drag, seeds):
    """Balls that are thrown, each filmed from the side."""
    true = equations_of(
        {
            "x": "vx",
            "vx": f"-{drag}*vx*{SPEED}",
            "y": "vy",
            "vy": f"-9.81 - {drag}*vy*{SPEED}",
        }
    )
    t, records = np.arange(0.0, 2.5, 0.004), []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        speed, angle = rng.uniform(10.0, 25.0), rng.uniform(0.4, 1.2)
        start = [0.0, speed * np.cos(angle), 0.0, speed * np.sin(angle)]
        places = pse.simulate(true, start, t)[:, [0, 2]]
        records.append(pse.prepare(t, places + 2e-3 * rng.standard_normal(places.shape)))
    return records


@pytest.mark.slow
@pytest.mark.parametrize("drag", [0.0, 0.02])
def test_the_drag_of_a_thrown_ball_depends_on_the_speed_in_the_plane(drag):
    declared = pse.DeclaredModel({"x": "vx", "vx": "0", "y": "vy", "vy": "-9.81"})
    # Terms may grow where nothing is missing.
    options = {"operators": (), "random_state": 0} if drag else {"random_state": 0}
    report = pse.close_loop(declared, throws(drag, range(4)), throws(drag, [9]), **options)
    found = {(effect.name, effect.state) for effect in report.effects}
    assert found == ({("quadratic drag", "vx"), ("quadratic drag", "vy")} if drag else set())
    for effect in report.effects:
        assert "sqrt(vx**2 + vy**2)" in str(effect.term)
        assert effect.coefficients[0] == pytest.approx(-drag, rel=0.03)


@pytest.mark.slow
def test_a_shaft_grows_stiffer_the_further_out_it_whirls():
    stiff = "(4 + 0.5*(x**2 + y**2))"
    true = equations_of(
        {
            "x": "vx",
            "vx": f"Fx - 0.2*vx - {stiff}*x",
            "y": "vy",
            "vy": f"Fy - 0.2*vy - {stiff}*y",
        },
        ("Fx", "Fy"),
    )
    t, records = np.arange(0.0, 40.0, 0.02), []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        phases = rng.uniform(0.0, 2.0 * np.pi, (2, 8))
        tones = np.multiply.outer(t, np.linspace(0.5, 4.0, 8))
        force = np.column_stack([np.sin(tones + phase).sum(axis=1) for phase in phases])
        places = pse.simulate(true, [0.0] * 4, t, u=force)[:, [0, 2]]
        noisy = places + 1e-3 * rng.standard_normal(places.shape)
        records.append(pse.prepare(t, noisy, force))
    declared = pse.DeclaredModel(
        {"x": "vx", "vx": "Fx - c*vx - k*x", "y": "vy", "vy": "Fy - c*vy - k*y"},
        inputs=["Fx", "Fy"],
    )
    report = pse.close_loop(declared, *records, operators=(), random_state=0)
    names = [(e.name, e.state, float(e.coefficients[0])) for e in report.effects]
    assert sorted(name[:2] for name in names) == [
        ("cubic stiffness", "vx"),
        ("cubic stiffness", "vy"),
    ]
    assert [c for _, _, c in names] == pytest.approx([-0.5, -0.5], rel=0.03)
