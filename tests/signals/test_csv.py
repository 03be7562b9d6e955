"""Reading measured columns from a text file, and what is refused."""

import re

import numpy as np
import pytest

from pysindy_evolve.signals import read_csv
from pysindy_evolve.signals.files import column_names


@pytest.fixture
def write(tmp_path):
    def _write(text, encoding="utf-8"):
        path = tmp_path / "record.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return _write


def test_all_columns_are_read_in_the_order_of_the_file(write):
    table = read_csv(write("t,q,F\n0,1.5,-2e-3\n0.1,1.6,4\n"))
    assert list(table) == ["t", "q", "F"]
    np.testing.assert_array_equal(table["F"], [-2e-3, 4.0])


def test_wanted_columns_are_read_in_the_order_asked_for(write):
    table = read_csv(write("t,q,note\n0,1,first\n1,2,second\n"), ["q", "t"])
    assert list(table) == ["q", "t"]
    np.testing.assert_array_equal(table["q"], [1.0, 2.0])


def test_spaces_empty_lines_byte_order_mark_and_quotes_do_no_harm(write):
    table = read_csv(write('\ufeff"t" , "q, m"\r\n 0, 1\r\n\r\n1 , 2 \r\n'.replace(' "q', '"q')))
    assert list(table) == ["t", "q, m"]
    np.testing.assert_array_equal(table["t"], [0.0, 1.0])


def test_another_delimiter_can_be_named(write):
    np.testing.assert_array_equal(read_csv(write("t;q\n0;1\n"), delimiter=";")["q"], [1.0])


def test_numbers_may_have_decimal_commas(write):
    table = read_csv(write("t;q\n0,5;-1,25e-3\n1;2\n"), delimiter=";", decimal=",")
    np.testing.assert_array_equal(table["t"], [0.5, 1.0])
    np.testing.assert_array_equal(table["q"], [-1.25e-3, 2.0])


def test_points_between_thousands_are_refused(write):
    with pytest.raises(ValueError, match=r"'1\.000' in column 'q', line 2"):
        read_csv(write("t;q\n0,5;1.000\n"), delimiter=";", decimal=",")


@pytest.mark.parametrize("options", [{"decimal": ","}, {"decimal": ";"}, {"decimal": ""}])
def test_a_decimal_sign_that_cannot_be_told_from_the_delimiter_is_refused(write, options):
    with pytest.raises(ValueError, match=r"read_csv\(decimal=...\) must be"):
        read_csv(write("t\n0\n"), **options)


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("", None, "got an empty file"),
        ("\n\n", None, "got an empty file"),
        ("t,q\n", None, "got a header alone"),
        ("t,q\n0,1\n", ["F"], "'F', no such column .* holds 't', 'q'"),
        ("t,q,q\n0,1,2\n", ["q"], "'q', 2 columns of that name"),
        ("t,q,q\n0,1,2\n", None, "'q', 2 columns of that name"),
        ("t,q\n0,1\n1,left\n", None, "'left' in column 'q', line 3"),
        ("t,q\n0,1\n\n1,nan\n", None, "'nan' in column 'q', line 4"),
        ("t,q\n0,1\n1,inf\n", None, "'inf' in column 'q', line 3"),
        ("t,q\n0,1\n1\n", None, "nothing in column 'q', line 3"),
        ("t,q\n0,\n", None, "nothing in column 'q', line 2"),
        ("t,q\n0,1_000\n", None, "'1_000' in column 'q', line 2"),
        ("t,q,F\n0,00,0,0000,1,000\n", None, "line 2 has 6 fields, the header 3. A decimal comma"),
        ("t,q,F\n0,1,2\n1,2,3,4\n", ["t"], "line 3 has 4 fields, the header 3"),
        ("t;q\n0;1\n", ["t"], r"one field, 't;q'. Is the delimiter ';'\? \(--delimiter ';'\)"),
        ("t;q\n0;1\n", None, r"Is the delimiter ';'"),
        ("t;q\n0;0,004\n", ["t"], r"Is the delimiter ';'"),
        ("t\tq\n0\t1\n", ["t"], r"Is the delimiter '\\t'"),
        ('t,q\n0,"0,004"\n', None, "'0,004' in column 'q', line 2. Decimal commas: export with"),
    ],
)
def test_an_unreadable_file_is_refused_and_the_place_named(write, text, columns, message):
    with pytest.raises(ValueError, match=r"^read_csv\(.*must " + "(?s:.*)" + message):
        read_csv(write(text), columns)


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("# Logger 3\nt,q\n0,1\n1,2\n", "# Logger 3"),
        ("# Logger 3, of May\nt,q\n0,1\n", "# Logger 3, of May"),
        ("% by hand\n% twice\nt,q\n0,1\n", "% by hand"),
        ("Logger 3\nRate: 100 Hz\nt,q\n0,1\n", "Logger 3"),
        ("rate,100\nmade,by,hand\n0,1\n", "rate, 100"),
        ("# no names\n0,1\n1,2\n", "# no names"),
    ],
)
@pytest.mark.parametrize("read", [read_csv, column_names])
def test_lines_before_the_names_are_quoted_and_to_be_deleted(write, text, first, read):
    message = rf"must begin with the line of names; got '{first}' as .*\. Delete the lines before"
    with pytest.raises(ValueError, match=message):
        read(write(text))


@pytest.mark.parametrize("read", [read_csv, column_names])
def test_a_file_without_names_is_told_to_need_them(write, read):
    message = r"begin with the line of names; got the numbers 0, -1\.5e-3\. Write a first line"
    with pytest.raises(ValueError, match=message):
        read(write("0,-1.5e-3\n1,2\n"))


def test_a_row_of_units_is_to_be_deleted(write):
    message = r"numbers below the line of names; got 's, 1/s' in line 2\. Delete .* holds units"
    with pytest.raises(ValueError, match=message):
        read_csv(write("t,q\ns,1/s\n0,1\n1,2\n"))
    with pytest.raises(
        ValueError, match=r"numbers below the line of names; got 's, 1/s' in line 2"
    ):
        read_csv(write("t,q\ns,1/s,\n0,1,\n1,2,\n"))


def test_names_behind_a_sign_are_names_as_numpy_writes_them(write):
    np.testing.assert_array_equal(read_csv(write("# t,q\n0,1\n1,2\n"), ["q"])["q"], [1.0, 2.0])


@pytest.mark.parametrize("ending", ["npz", "mat", "NPY"])
def test_files_of_arrays_are_not_read_and_prepare_takes_their_arrays(tmp_path, ending):
    path = tmp_path / f"record.{ending}"
    path.write_text("t,q\n0,1\n", encoding="utf-8")
    message = r"files of arrays are not read\. .* arrays to pysindy_evolve\.prepare\(t, y, u\)"
    with pytest.raises(ValueError, match=message):
        read_csv(path)


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "record.xlsx"
    path.write_bytes(b"PK\x03\x04\xff\xfe\x00\x9d\n\xff")
    with pytest.raises(ValueError, match=r"must be a text file in UTF-8"):
        read_csv(path)


def test_another_encoding_is_refused_and_the_right_one_named(write):
    with pytest.raises(ValueError, match=r"Export the record as CSV in UTF-8\.$"):
        read_csv(write("t,q\n0,1\n", encoding="utf-16"))


def test_an_empty_field_at_the_end_of_a_row_does_no_harm(write):
    np.testing.assert_array_equal(read_csv(write("t,q\n0,1,\n1,2,\n"))["q"], [1.0, 2.0])


def test_a_name_alone_is_no_list_of_columns(write):
    with pytest.raises(TypeError, match=re.escape("read_csv(columns=...) must be a sequence")):
        read_csv(write("t,q\n0,1\n"), "q")


def test_a_delimiter_of_two_characters_is_refused(write):
    with pytest.raises(ValueError, match=r"must be one character; got '::'"):
        read_csv(write("t\n0\n"), delimiter="::")


def test_a_missing_file_keeps_its_own_error(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere"):
        read_csv(tmp_path / "nowhere.csv")


LATE = "t,q,F\n0,,1\n1, ,1\n2,5,1\n3,6,\n4,7,1\n5,,1\n6\n"


def test_empty_rows_at_both_ends_are_left_out_where_that_is_asked_for(write):
    with pytest.raises(ValueError, match=r"nothing in column 'q', line 2\. .*--drop-empty\) drops"):
        read_csv(write(LATE), ["t", "q"])
    read = read_csv(write(LATE), ["t", "q"], drop_empty=True)
    assert {name: list(column) for name, column in read.items()} == {"t": [2, 3, 4], "q": [5, 6, 7]}


def test_a_gap_is_not_left_out_and_the_way_out_told(write):
    gap = r"at the end only; got nothing in column 'F', line 5\. Cut the file there into two"
    with pytest.raises(ValueError, match=gap):
        read_csv(write(LATE), ["t", "q", "F"], drop_empty=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,q,F\n0,1,\n1,2,\n2,,3\n", "most are empty in 'F'"),
        ("t,q,F\n0,,1\n1,two,1\n", "got 'two' in column 'q', line 3"),
    ],
)
def test_what_is_no_empty_end_is_still_refused(write, text, message):
    with pytest.raises(ValueError, match=message):
        read_csv(write(text), drop_empty=True)
