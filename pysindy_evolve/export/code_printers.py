"""How each language writes an expression: sympy's code printers, completed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sympy.core.function import AppliedUndef
from sympy.printing.c import C99CodePrinter
from sympy.printing.julia import JuliaCodePrinter
from sympy.printing.numpy import SciPyPrinter
from sympy.printing.octave import OctaveCodePrinter
from sympy.printing.str import StrPrinter


class _Exact:
    """Prints floats with all their digits; sympy stops at fifteen."""

    def _print_Float(self, expression: Any) -> str:
        return repr(float(expression))


class _Extremes:
    """Prints max and min of more than two arguments as nested calls: max(max(a, b), c)."""

    larger, smaller = "max", "min"

    def _print_Max(self, expression: Any) -> str:
        return self._of_two(self.larger, expression.args)

    def _print_Min(self, expression: Any) -> str:
        return self._of_two(self.smaller, expression.args)

    def _of_two(self, name: str, arguments: Sequence[Any]) -> str:
        first, *rest = (str(self._print(argument)) for argument in arguments)  # type: ignore[attr-defined]
        for other in rest:
            first = f"{name}({first}, {other})"
        return first


class PythonPrinter(_Extremes, _Exact, SciPyPrinter):
    """Python with numpy; arrays are compared element by element."""

    larger, smaller = "numpy.maximum", "numpy.minimum"


class CPrinter(_Exact, C99CodePrinter):
    """C of 1999."""

    def _print_Integer(self, expression: Any) -> str:
        return f"{int(expression)}.0"  # whole numbers must not meet in integer arithmetic


class MatlabPrinter(_Exact, OctaveCodePrinter):
    """MATLAB and Octave."""


class JuliaPrinter(_Extremes, _Exact, JuliaCodePrinter):
    """Julia."""


_MODELICA_KNOWS = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh"}
_MODELICA_KNOWS |= {"exp", "log", "sqrt", "sign", "floor"}


class ModelicaPrinter(_Extremes, _Exact, StrPrinter):
    """Modelica; raises NotImplementedError for functions that it does not have."""

    def __init__(self, settings: dict[str, Any]) -> None:
        super().__init__()

    def _print_Abs(self, expression: Any) -> str:
        return f"abs({self._print(expression.args[0])})"

    def _print_Function(self, expression: Any) -> str:
        name = expression.func.__name__
        if name not in _MODELICA_KNOWS and not isinstance(expression, AppliedUndef):
            raise NotImplementedError(f"{name} is no function of Modelica")
        return str(super()._print_Function(expression))

    def _print_Piecewise(self, expression: Any) -> str:
        raise NotImplementedError(f"{expression.func.__name__} is no function of Modelica")

    _print_Heaviside = _print_Piecewise

    def _print_Pow(self, expression: Any, rational: bool = False) -> str:
        return str(super()._print_Pow(expression, rational)).replace("**", "^")
