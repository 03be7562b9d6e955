"""Pictures of the residual: the panels show what the report holds, labeled with units."""

import numpy as np
import pytest

import pysindy_evolve as pse

pytest.importorskip("matplotlib")
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

UNITS = {"q": "m", "v": "m/s", "F": "N", "t": "s"}


@pytest.fixture
def panels(report):
    figure = report.plot(units=UNITS)
    assert isinstance(figure, Figure)
    yield {axes.get_title(loc="left").split(":")[0]: axes for axes in figure.axes}
    plt.close(figure)


def test_picture_shows_time_frequency_variables_and_phase_plane(panels):
    assert set(panels) >= {
        "Over time",
        "Over frequency",
        "Over v",
        "Mean residual, declared model",
        "Mean residual, corrected model",
    }


def test_axes_carry_the_units_of_the_user(panels):
    assert panels["Over time"].get_xlabel() == "t [s]"
    assert panels["Over time"].get_ylabel() == "residual of dv/dt [m/s²]"
    assert panels["Over frequency"].get_xlabel() == "frequency [Hz]"
    assert panels["Over v"].get_xlabel() == "v [m/s]"
    plane = panels["Mean residual, declared model"]
    assert (plane.get_xlabel(), plane.get_ylabel()) == ("q [m]", "v [m/s]")


def test_friction_is_seen_over_the_speed_before_and_not_after(panels):
    before, after = (line.get_ydata() for line in panels["Over v"].lines[:2])
    assert np.ptp(before) > 5 * np.ptp(after)


def test_picture_of_a_complete_model_shows_one_residual_and_plain_names(complete):
    figure = complete.plot("q")
    panels = {axes.get_title(loc="left").split(":")[0]: axes for axes in figure.axes}
    over_time = panels["Over time"]
    assert over_time.get_ylabel() == "residual of dq/dt"
    assert over_time.get_xlabel() == "t"
    assert len([line for line in over_time.lines if len(line.get_xdata()) > 2]) == 1
    assert "Mean residual, corrected model" not in panels
    plt.close(figure)


def test_picture_of_a_state_that_is_none_is_refused(report):
    with pytest.raises(ValueError, match=r"plot\(state=\.\.\.\) must be a state of the model; got"):
        report.plot("w")


def test_unit_of_something_that_is_no_variable_is_refused(report):
    with pytest.raises(ValueError, match=r"plot\(units=\.\.\.\) must name variables of the model"):
        report.plot(units={"x": "m"})


def test_first_order_model_without_inputs_is_drawn_over_time_too():
    t = np.arange(0.0, 20.0, 0.01)
    x = np.exp(-0.4 * t)
    record = pse.Record(t=t, x=x, x_dot=-0.4 * x)
    report = pse.close_loop(pse.DeclaredModel({"x": "-k*x"}), record, operators=(), random_state=0)
    figure = report.plot()
    planes = [axes for axes in figure.axes if "Mean" in axes.get_title(loc="left")]
    assert planes[0].get_xlabel() == "t"
    plt.close(figure)
