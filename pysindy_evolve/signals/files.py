"""Measured signals from a CSV file."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path

import numpy as np

from .spectral import Array

ARRAYS = {".npz", ".npy", ".mat"}  # endings of files that hold arrays, and no text
COMMENTS = ("#", "%", "//")  # beginnings of comment lines
NUMBER = re.compile(r"[-+]?[.,]?\d[\d.,_]*([eE][-+]?\d+)?|nan|[-+]?inf", re.IGNORECASE)
FIRST_ROWS = 100  # rows in which the names are looked for, if they are not in the first line


def read_csv(
    path: str | PathLike[str],
    columns: Sequence[str] | None = None,
    delimiter: str = ",",
    decimal: str = ".",
    *,
    drop_empty: bool = False,
) -> dict[str, Array]:
    r"""Read named columns of numbers from a CSV file whose first line holds the names.

    Parameters
    ----------
    path : str or path-like
        The file.
    columns : sequence of str, optional
        Names of the columns wanted, in this order; all columns by default.
    delimiter : str
        One character between the fields.
    decimal : {".", ","}
        Decimal separator; often a comma in files with semicolons between the fields.
    drop_empty : bool
        Leave out the rows at the beginning and at the end in which a wanted column is empty, as
        when a sensor starts late. A gap in between is an error: it makes two records.

    Returns
    -------
    dict of str to ndarray of shape (n_samples,)

    Raises
    ------
    ValueError
        If a separator is invalid, the file is empty, a name is missing or occurs twice, a row is
        too short or too long, a value is not a finite number, or there is a gap. The message names
        the line of the file.
    TypeError
        If `columns` is not a sequence of names.
    FileNotFoundError
        If there is no such file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from pysindy_evolve.signals import read_csv
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "record.csv"
    >>> _ = path.write_text("t,q\n0.0,1.5\n0.1,1.6\n")
    >>> read_csv(path, ["q"])
    {'q': array([1.5, 1.6])}
    """
    if not isinstance(delimiter, str) or len(delimiter) != 1:
        raise ValueError(
            f"read_csv(delimiter=...) must be one character; got {delimiter!r}. "
            'Use "," or ";" or "\\t".'
        )
    if decimal not in (".", ",") or decimal == delimiter:
        raise ValueError(
            'read_csv(decimal=...) must be "." or "," and not the delimiter; got '
            f'{decimal!r} with the delimiter {delimiter!r}. Use delimiter=";" for decimal commas.'
        )
    if isinstance(columns, str) or not all(isinstance(name, str) for name in columns or ()):
        raise TypeError(
            f"read_csv(columns=...) must be a sequence of names; got {columns!r}. "
            'Give a list, such as ["t", "q"].'
        )
    header, rows = _read(Path(fspath(path)), delimiter)
    _check_fields(header, rows)
    wanted = list(header) if columns is None else list(columns)
    places = [_place(header, name, path) for name in wanted]
    if drop_empty:
        rows = _without_empty_ends(rows, dict(zip(wanted, places, strict=True)))
    return {
        name: np.array([_value(row, place, name, line, decimal) for line, row in rows])
        for name, place in zip(wanted, places, strict=True)
    }


def column_names(path: str | PathLike[str], delimiter: str = ",") -> list[str]:
    """Return the names in the first line of a CSV file."""
    header, rows = _read(Path(fspath(path)), delimiter)
    _check_fields(header, rows)
    return header


def _read(path: Path, delimiter: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the names, and the rows, each with its line number; empty lines are skipped."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as lines:
            if path.suffix.lower() in ARRAYS:
                raise ValueError(
                    f"read_csv(path=...) must be a text file in UTF-8; got {str(path)!r}, and "
                    "files of arrays are not read. Load it and pass its arrays to "
                    "pysindy_evolve.prepare(t, y, u), or export the record as CSV."
                )
            reader = csv.reader(lines, delimiter=delimiter)
            rows = [(reader.line_num, row) for row in reader if any(f.strip() for f in row)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(
            f"read_csv(path=...) must be a text file in UTF-8; got {str(path)!r} ({error}). "
            "Export the record as CSV in UTF-8."
        ) from error
    if len(rows) < 2:
        got = "an empty file" if not rows else "a header alone"
        raise ValueError(
            f"read_csv(path=...) must hold a line of names and rows of numbers; got {got}, "
            f"{str(path)!r}. Export the record again."
        )
    return [name.strip() for name in rows[0][1]], rows[1:]


def _check_fields(header: list[str], rows: list[tuple[int, list[str]]]) -> None:
    """Raise an error if fields and names do not match; empty fields at the end are allowed."""
    second_line = "".join(rows[0][1])
    for delimiter in (";", "\t", "|", ","):
        if len(header) == 1 and delimiter in header[0] and delimiter in second_line:
            raise ValueError(
                f"read_csv(delimiter=...) must be the sign between the names; got one field, "
                f"{header[0]!r}. Is the delimiter {delimiter!r}? (--delimiter {delimiter!r})"
            )
    _check_header(header, rows)
    for line, row in rows:
        if any(field.strip() for field in row[len(header) :]):
            raise ValueError(
                f"read_csv(path=...) must have a name for each field; got a file whose line {line} "
                f"has {len(row)} fields, the header {len(header)}. A decimal comma? Export with "
                "points, or semicolons between the fields."
            )


def _check_header(header: list[str], rows: list[tuple[int, list[str]]]) -> None:
    """Raise an error unless the names are in the first line, and numbers in the second."""
    line, second = rows[0]
    names = ", ".join(name for name in header if name)
    no_numbers = not _has_number(second)
    without_numbers = [row for _, row in rows[:FIRST_ROWS] if not _has_number(row)]
    is_wider = any(field.strip() for row in without_numbers for field in row[len(header) :])
    # A comment sign may stand before the names, as numpy writes them: then numbers follow.
    is_comment = names.startswith(COMMENTS) and (no_numbers or len(second) > len(header))
    if is_comment or is_wider:
        raise ValueError(
            f"read_csv(path=...) must begin with the line of names; got {names!r} as the first "
            "line. Delete the lines before the names, or skip them with a reader of your own and "
            "pass the arrays to prepare."
        )
    if all(NUMBER.fullmatch(name) for name in header):
        raise ValueError(
            f"read_csv(path=...) must begin with the line of names; got the numbers {names}. Write "
            "a first line with a name for each column, such as t,q,F."
        )
    if no_numbers:
        found = ", ".join(field.strip() for field in second if field.strip())
        raise ValueError(
            f"read_csv(path=...) must have numbers below the line of names; got {found!r} in line "
            f"{line}. Delete this row if it holds units; if it holds the names, what is before it."
        )


def _has_number(row: list[str]) -> bool:
    """Tell whether any field of a row is a number, however its decimals are written."""
    return any(NUMBER.fullmatch(field.strip()) for field in row)


def _place(header: list[str], name: str, path: str | PathLike[str]) -> int:
    """Return the index of a column, whose name must occur exactly once."""
    count = header.count(name)
    if count != 1:
        problem = "no such column" if not count else f"{count} columns of that name"
        raise ValueError(
            f"read_csv(columns=...) must be names that occur once; got {name!r}, {problem} in "
            f"{fspath(path)!r}. The file holds {', '.join(map(repr, header))}."
        )
    return header.index(name)


def _without_empty_ends(
    rows: list[tuple[int, list[str]]], places: dict[str, int]
) -> list[tuple[int, list[str]]]:
    """Return the rows from the first to the last without an empty wanted field.

    An empty field in between is an error.
    """
    full = [i for i, (_, row) in enumerate(rows) if all(_text(row, k) for k in places.values())]
    if not full:
        empty = max(places, key=lambda name: sum(not _text(row, places[name]) for _, row in rows))
        raise ValueError(
            f"read_csv(path=...) must hold a row in which no wanted column is empty; got none, and "
            f"most are empty in {empty!r}. Leave out this column, or read its rows from another "
            "file."
        )
    inner = rows[full[0] : full[-1] + 1]
    for line, row in inner:
        for name, place in places.items():
            if not _text(row, place):
                raise ValueError(
                    "read_csv(path=...) must have empty rows at the beginning and at the "
                    f"end only; got nothing in column {name!r}, line {line}. Cut the file there "
                    "into two, each a record of its own, or fill the gap."
                )
    return inner


def _text(row: list[str], place: int) -> str:
    """Return the text of a field; empty beyond the end of a row."""
    return row[place].strip() if place < len(row) else ""


def _value(row: list[str], place: int, name: str, line: int, decimal: str) -> float:
    """Return a field as a finite number, or raise an error."""
    text = _text(row, place)
    try:
        mixed = "_" in text or (decimal != "." and "." in text)
        value = np.nan if mixed else float(text.replace(decimal, "."))
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        got = repr(text) if text else "nothing"
        is_comma = re.fullmatch(r"[-+]?\d*,\d+([eE][-+]?\d+)?", text) is not None
        advice = (
            'Decimal commas: export with points, or give decimal="," (--decimal ,).'
            if is_comma
            else "Correct or drop this row."
        )
        if not text:
            advice += " drop_empty=True (--drop-empty) drops those at the beginning and the end."
        raise ValueError(
            f"read_csv(path=...) must hold finite numbers; got {got} in column {name!r}, "
            f"line {line}. {advice}"
        )
    return value
