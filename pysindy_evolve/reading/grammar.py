"""Parses text or sympy into a syntax tree of arithmetic and calls only.

The text is first cut into numbers, names and the signs ``+ - * / ** ^ ( ) ,``. Only these reach
Python's own expression grammar, which settles the precedence. Names are passed to it as _0, _1,
..., so that none can be a keyword or an attribute.
"""

from __future__ import annotations

import ast
import math
import re
from numbers import Real
from typing import Any, NamedTuple, NoReturn

import sympy
from sympy.printing.str import StrPrinter

MAX_TOKENS = 5000
MAX_DEPTH = 30  # levels of nesting, far below Python's limit of recursion
MAX_SIZE = 2000  # nodes of the result, as powers of sums of powers grow without bound
MAX_EXPONENT = 64

_TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[^\W\d]\w*)|(?P<sign>\*\*|[-+*/^(),])"
)
# Advice for signs that look like others, in text that was copied from a page.
_MEANT = {"=": "Give the right-hand side alone."}
_MEANT |= dict.fromkeys("\u2212\u2013\u2014", "Use - (the minus of the keyboard).")
_MEANT |= dict.fromkeys("\u00b7\u22c5\u00d7", "Write a product with *.")
_CHAINS: dict[type, tuple[type, ...]] = {
    ast.Add: (ast.Add, ast.Sub),
    ast.Sub: (ast.Add, ast.Sub),
    ast.Mult: (ast.Mult, ast.Div),
    ast.Div: (ast.Mult, ast.Div),
}


class _Token(NamedTuple):
    kind: str
    text: str
    start: int


class Source:
    """A text, its syntax tree, and errors that point into it.

    Parameters
    ----------
    text : str
        The expression.
    owner : str
        The call and parameter to name in an error, such as ``parse(text=...)``.

    Attributes
    ----------
    names : list of str
        Names in the order of the text, repeated as often as they occur.
    tree : ast.expr
        Syntax tree of numbers, names, ``+ - * / **``, signs and calls.
    """

    def __init__(self, text: str, owner: str) -> None:
        self.text, self.owner = text, owner
        self.names: list[str] = []
        self._starts: list[int] = []  # position in the text of each character that is parsed
        self.tree = self._parsed(self._tokens())
        self._check_depth()

    def name(self, node: ast.Name) -> str:
        """Return the name that the user wrote."""
        return self.names[int(node.id[1:])]

    def fail(
        self, constraint: str, got: str, advice: str, node: ast.expr | None = None
    ) -> NoReturn:
        """Raise the error of the house form, with the position of a node."""
        where = "" if node is None else self._at(self._start(node))
        raise ValueError(f"{self.owner} {constraint}; got {got}{where}. {advice}")

    def fail_syntax(self, node: ast.expr | int) -> NoReturn:
        """Raise the error of a text that is no expression."""
        position = node if isinstance(node, int) else self._start(node)
        self.fail(
            "must be an expression",
            f"a syntax error{self._at(position)}",
            "Check its operators and parentheses.",
        )

    def fail_number(self, node: ast.expr) -> NoReturn:
        """Raise the error of a number that overflows or does not exist."""
        advice = "Check divisions by zero, and logarithms, roots and powers of constants."
        self.fail("must have finite values", "one that is not", advice, node)

    def fail_size(self, node: ast.expr | int) -> NoReturn:
        """Raise the error of a text that is too long or too deep."""
        position = node if isinstance(node, int) else self._start(node)
        self.fail(
            f"must stay below {MAX_TOKENS} symbols, {MAX_DEPTH} levels, {MAX_SIZE} nodes and "
            f"exponents of {MAX_EXPONENT}",
            f"more{self._at(position)}",
            "Simplify the expression.",
        )

    def _tokens(self) -> list[_Token]:
        tokens: list[_Token] = []
        opened: list[int] = []
        position = 0
        while position < len(self.text):
            match = _TOKEN.match(self.text, position)
            if match is None:
                self._fail_character(position)
            token = _Token(str(match.lastgroup), match.group(), position)
            position = match.end()
            if token.kind == "space":
                continue
            self._check_neighbors(tokens[-1] if tokens else None, token)
            if token.text == "," and not opened:
                self._fail_comma(tokens, position)
            if token.text == "(":
                opened.append(position)
            elif token.text == ")" and not opened:
                self.fail_syntax(token.start)
            elif token.text == ")":
                opened.pop()
            tokens.append(token)
            if len(opened) > MAX_DEPTH or len(tokens) > MAX_TOKENS:
                self.fail_size(token.start)
        if not tokens:
            self.fail("must not be empty", repr(self.text[:20]), 'Write for example "-k*q - c*v".')
        if opened:
            self.fail_syntax(opened[-1] - 1)
        return tokens

    def _check_neighbors(self, before: _Token | None, token: _Token) -> None:
        if before is None or (token.kind == "sign" and token.text != "("):
            return
        ends_operand = before.kind != "sign" or before.text == ")"
        is_call = before.kind == "name" and token.text == "("
        if ends_operand and not is_call:
            self.fail(
                "must have an operator between two factors",
                f"{before.text!r} followed by {token.text!r}{self._at(token.start)}",
                "Write a product with *.",
            )

    def _parsed(self, tokens: list[_Token]) -> ast.expr:
        pieces = []
        for token in tokens:
            pieces.append(self._piece(token))
            self._starts += [token.start] * (len(pieces[-1]) + 1)
        try:
            return ast.parse(" ".join(pieces), mode="eval").body
        except SyntaxError as error:
            place = (error.offset or 0) - 1  # past the end if something is missing there
            inside = 0 <= place < len(self._starts)
            self.fail_syntax(self._starts[place] if inside else len(self.text))
        except (RecursionError, MemoryError):
            self.fail_size(0)

    def _piece(self, token: _Token) -> str:
        """Return the text that Python's grammar gets in place of a token."""
        if token.kind == "name":
            self.names.append(token.text)
            return f"_{len(self.names) - 1}"
        if token.kind != "number":
            return "**" if token.text == "^" else token.text
        value = float(token.text)
        if not math.isfinite(value):
            got = f"{token.text[:20]}{self._at(token.start)}"
            self.fail("must hold finite numbers", got, "Use other units.")
        return repr(value)

    def _check_depth(self) -> None:
        stack = [(self.tree, 0)]
        while stack:
            node, depth = stack.pop()
            if depth > MAX_DEPTH:
                self.fail_size(node)
            if isinstance(node, ast.BinOp):
                children: list[ast.expr] = [operand for _, operand in chain(node)]
            else:
                children = [c for c in ast.iter_child_nodes(node) if isinstance(c, ast.expr)]
            stack += [(child, depth + 1) for child in children]

    def _start(self, node: ast.expr) -> int:
        return self._starts[min(node.col_offset, len(self._starts) - 1)]

    def _at(self, position: int) -> str:
        start = max(position - 20, 0)
        before, after = self.text[start:position], self.text[position : position + 20]
        dots = "..." if start else "", "..." if position + 20 < len(self.text) else ""
        return f" at character {position + 1} of {dots[0] + before + after + dots[1]!r}"

    def _fail_comma(self, before: list[_Token], position: int) -> NoReturn:
        """Raise the error of a comma outside of parentheses; `position` is just behind it."""
        digits = re.match(r"[0-9]+", self.text[position:])
        advice = "Commas stand between the arguments of a function only."
        if digits and before and before[-1].kind == "number":
            advice = f"Write {before[-1].text}.{digits.group()}."
        self.fail("must be an expression", f"a comma{self._at(position - 1)}", advice)

    def _fail_character(self, position: int) -> NoReturn:
        default = "Use numbers, names, + - * / ** ( ) and calls of known functions only."
        advice = _MEANT.get(self.text[position], default)
        got = f"{self.text[position]!r}{self._at(position)}"
        self.fail("must be an expression", got, advice)


def chain(node: ast.BinOp) -> list[tuple[ast.operator | None, ast.expr]]:
    """Return the operands of a - b + c or a * b / c from left to right, with their operators.

    A sum is nested as deep as it has parts, so it is unrolled: recursion would go too deep.
    """
    links: list[tuple[ast.operator | None, ast.expr]] = []
    left: ast.expr = node
    kinds = _CHAINS.get(type(node.op), (type(node.op),))
    while isinstance(left, ast.BinOp) and isinstance(left.op, kinds):
        links.append((left.op, left.right))
        left = left.left
    return [(None, left), *reversed(links)]


class _Printer(StrPrinter):
    """Prints sympy expressions as text that `parse` reads, floats in full."""

    def _print_Float(self, expression: Any) -> str:
        value = repr(float(expression))
        return f"({value})" if value.startswith("-") else value


def as_text(text: Any, owner: str) -> str:
    """Return text as it is, and a number or sympy expression as text."""
    if isinstance(text, str):
        return text
    is_bool = isinstance(text, bool)
    if isinstance(text, Real) and not is_bool:
        text = sympy.Float(float(text))
    if not isinstance(text, sympy.Expr):
        raise TypeError(
            f"{owner} must be text, a sympy expression or a number; got {type(text).__name__}. "
            'Write for example "-k*q - c*v".'
        )
    if text.has(sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo):
        raise ValueError(f"{owner} must be real and finite; got {text}. Check the expression.")
    for symbol in text.free_symbols:
        if not symbol.name.isidentifier():
            raise ValueError(
                f"{owner} must have identifiers as symbols; got {symbol.name!r}. "
                "Rename the symbol with letters, digits and underscores."
            )
    numbers = text.atoms(sympy.NumberSymbol)  # E, pi and others would print as names
    return str(_Printer().doprint(text.xreplace({n: sympy.Float(float(n)) for n in numbers})))
