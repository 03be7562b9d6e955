"""The machines: their declared equations, true parameters and input."""

from dataclasses import dataclass


@dataclass(frozen=True)
class System:
    """A machine: declared equations with true parameters, and where the effect enters."""

    equations: dict
    parameters: dict
    order: int  # states of each measured column
    state: str  # whose equation the effect enters
    position: str  # called q in the effects below
    dt: float
    band: tuple  # lowest and highest frequency of the input
    start: tuple
    force: str  # RMS of this is what effects are measured by
    shaken: str = "1"  # what process noise multiplies

    @property
    def measured(self) -> list[int]:
        return list(range(0, len(self.equations), self.order))


SYSTEMS = {
    "oscillator": System(
        {"q": "v", "v": "-k*q - c*v + b*u"},
        {"k": 40.0, "c": 0.8, "b": 10.0},
        2, "v", "q", 0.015, (0.1, 1.6), (0.0, 0.0), "b*u",
    ),
    "duffing": System(
        {"q": "v", "v": "-k*q - e*q**3 - c*v + b*u"},
        {"k": 10.0, "e": 60.0, "c": 0.5, "b": 6.0},
        2, "v", "q", 0.02, (0.1, 1.2), (0.1, 0.0), "b*u",
    ),
    "pendulum": System(
        {"q": "v", "v": "-g*sin(q) - c*v + b*u"},
        {"g": 20.0, "c": 0.6, "b": 2.5},
        2, "v", "q", 0.02, (0.1, 1.2), (0.5, 0.0), "b*u",
    ),
    "rolling mass": System(
        {"q": "v", "v": "-c*v + b*u"},
        {"c": 0.6, "b": 4.0},
        2, "v", "q", 0.02, (0.1, 1.0), (0.0, 0.0), "b*u",
    ),
    "two masses": System(
        {"p": "w", "w": "-k*p - c*w + s*(q - p) + b*u", "q": "v", "v": "-r*(q - p) - d*v"},
        {"k": 30.0, "c": 0.6, "s": 20.0, "b": 10.0, "r": 25.0, "d": 0.5},
        2, "v", "q", 0.015, (0.1, 1.6), (0.0, 0.0, 0.0, 0.0), "r*(q - p)",
    ),
    "circuit": System(
        {"v": "-a*v + b*u"},
        {"a": 1.5, "b": 3.0},
        1, "v", "v", 0.02, (0.02, 0.8), (0.0,), "b*u",
    ),
    "population": System(
        {"v": "a*v - f*v**2 - b*v*w + h*u*v", "w": "-c*w + d*v*w"},
        {"a": 2.0, "f": 0.2, "b": 0.8, "h": 0.5, "c": 1.2, "d": 0.6},
        1, "v", "v", 0.04, (0.05, 0.4), (2.0, 1.5), "b*v*w", "v/5",
    ),
}  # fmt: skip
