"""The names of all effects, each written once, as code compares them.

A saturation may also be a state that stops at a limit; delays, lags and hidden states may also be
memories of inputs. These names are defined with limits and memories.
"""

from __future__ import annotations

from ...hidden_states.memory import DELAY, LAG, VESSEL
from ..given.limits import LIMITED

COULOMB_FRICTION = "Coulomb friction"
ASYMMETRIC_FRICTION = "asymmetric Coulomb friction"
STRIBECK_FRICTION = "Stribeck friction"
POSITION_FRICTION = "position-dependent friction"
VISCOUS_DAMPING = "viscous damping"
QUADRATIC_DRAG = "quadratic drag"
NONLINEAR_DAMPING = "nonlinear damping"
LINEAR_STIFFNESS = "linear stiffness"
QUADRATIC_STIFFNESS = "quadratic stiffness"
CUBIC_STIFFNESS = "cubic stiffness"
QUINTIC_STIFFNESS = "quintic stiffness"
ASYMMETRIC_STIFFNESS = "asymmetric stiffness"
DEAD_ZONE = "dead zone"
GRAVITY = "gravity"
HARMONIC = "second harmonic"
CONSTANT_OFFSET = "constant offset"
COUPLING = "coupling"
INPUT_NONLINEARITY = "input nonlinearity"
INPUT_GAIN = "input gain"
SATURATING = "saturating rate"
VALVE = "valve flow"
DRIFT = "drift"
FORCING = "periodic forcing"
RIPPLE = "position-periodic ripple"
INERTIA = "position-dependent inertia"
HYSTERESIS = "hysteresis"
SATURATION = LIMITED
HIDDEN_STATE = VESSEL
EVOLVED = "evolved term"  # two of this name are two effects, not two shapes of one

VOCABULARY = (
    COULOMB_FRICTION,
    ASYMMETRIC_FRICTION,
    STRIBECK_FRICTION,
    POSITION_FRICTION,
    VISCOUS_DAMPING,
    QUADRATIC_DRAG,
    NONLINEAR_DAMPING,
    LINEAR_STIFFNESS,
    QUADRATIC_STIFFNESS,
    CUBIC_STIFFNESS,
    QUINTIC_STIFFNESS,
    ASYMMETRIC_STIFFNESS,
    DEAD_ZONE,
    SATURATION,
    GRAVITY,
    HARMONIC,
    CONSTANT_OFFSET,
    COUPLING,
    INPUT_NONLINEARITY,
    INPUT_GAIN,
    SATURATING,
    VALVE,
    DRIFT,
    FORCING,
    RIPPLE,
    INERTIA,
    DELAY,
    LAG,
    HYSTERESIS,
    HIDDEN_STATE,
    EVOLVED,
)


def order_of(name: str) -> int:
    """Return the place of a name in the vocabulary, simple effects first; unknown ones are last."""
    return VOCABULARY.index(name) if name in VOCABULARY else len(VOCABULARY)
