"""What a machine may lack, and the names that count as finding it."""

from .systems import System

# Q, V, U: RMS of position, speed and input on the nominal path; L: length of the record; W: angular
# frequency midway between two lines of the input, as no record tells a forcing from a line of the
# input at the same frequency. bouc_wen(q, v, length, unloading) is a state of its own.
MECHANICAL = {
    "Coulomb": ("sgn(v)", {"Coulomb friction"}),
    "Stribeck": ("sgn(v)*(1 + 2*exp(-(v/(0.3*V))**2))", {"Coulomb friction", "Stribeck friction"}),
    "drag": ("v*abs(v)", {"quadratic drag"}),
    "v^3": ("v**3", {"nonlinear damping"}),
    "offset": ("1", {"constant offset"}),
    "q^2": ("q**2", {"quadratic stiffness", "constant offset", "gravity"}),
    "q^3": ("q**3", {"cubic stiffness", "gravity"}),
    "dead zone": ("q - clip(q, 0.5*Q)", {"dead zone"}),
    "|q|sgn(v)": ("abs(q)*sgn(v)", {"position-dependent friction"}),
    "q^2 v": ("q**2*v", {"nonlinear damping"}),
    "u|u|": ("u*abs(u)", {"input nonlinearity"}),
    "saturation": ("clip(u, 0.8*U) - u", {"saturation"}),
    "forcing": ("sin(W*t)", {"periodic forcing"}),
    "drift": ("t/L", {"drift", "constant offset"}),
    "hysteresis": ("bouc_wen(q, v, 0.3*Q, 0.5)", {"hysteresis"}),
    "*v cos(q)": ("v*cos(2*q/Q)", None),
    "*tanh(q)": ("tanh(q/(0.3*Q))", None),
    "*q|v|": ("q*abs(v)", None),
    "*sqrt|v|": ("sqrt(abs(v))*sgn(v)", None),
    "*q|q|": ("q*abs(q)", None),
    "*exp(q)": ("exp(q/Q)", None),
}
ON_SPEED = ("Coulomb", "Stribeck", "drag", "v^3", "offset", "u|u|", "saturation", "*sqrt|v|")
ROLLING = {name: MECHANICAL[name] for name in (*ON_SPEED, "forcing", "drift")}
FIRST_ORDER = {
    "offset": ("1", {"constant offset"}),
    "square": ("v*abs(v)", {"quadratic drag"}),
    "cube": ("v**3", {"nonlinear damping"}),
    "u|u|": ("u*abs(u)", {"input nonlinearity"}),
    "forcing": ("sin(W*t)", {"periodic forcing"}),
    "*v/(c+v)": ("v/(V + abs(v))", None),
    "*sqrt": ("sqrt(abs(v))*sgn(v)", None),
    "*tanh": ("tanh(v/(0.3*V))", None),
    "*exp": ("exp(v/V)", None),
}
POPULATION = {  # of which no more may be taken than there is: a steady removal would wipe it out
    "offset": ("-1", {"constant offset"}),
    "cube": ("v**3", {"nonlinear damping"}),
    "w": ("-w", {"coupling"}),
    "w^2": ("w**2", {"coupling"}),
    "u": ("u", {"input gain"}),
    "forcing": ("sin(W*t)", {"periodic forcing"}),
    "*v/(c+v)": ("v/(V + v)", None),
    "*vw/(c+v)": ("v*w/(V + v)", None),
    "*sqrt": ("sqrt(v)", None),
}


def effects_of(system: System) -> dict:
    right_hand_side = system.equations[system.state]
    if system.order == 2:
        known = {"q^3"} if "q**3" in right_hand_side else set()
        table = MECHANICAL if "q" in right_hand_side else ROLLING
        return {name: effect for name, effect in table.items() if name not in known}
    return POPULATION if "w" in system.equations else FIRST_ORDER
