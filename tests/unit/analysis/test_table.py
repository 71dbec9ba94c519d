"""What a table says for people, on the page and in a spreadsheet, whatever names it holds."""

import pytest

from mrsfi_runtime.analysis.tables import Table, as_csv, plain, to_markdown, to_page


def test_no_name_is_a_formula_in_a_spreadsheet():
    names = ("=1+1", "+1", "-x", "@SUM(A1)", "\tx", "a=b", "", "–")

    rows = as_csv([(name, -1.5) for name in names]).decode()

    told = ("'=1+1", "'+1", "'-x", "'@SUM(A1)", "'\tx", "a=b", "", "–")
    assert rows == "".join(f"{name},-1.5\n" for name in told)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("\x1b]0;title\x07a\x1b[31m", r"\x1b]0;title\x07a\x1b[31m"),
        ("a\u202eb\udcff", r"a\u202eb\udcff"),
        ("a\n# b\t|c<d", r"a # b \|c&lt;d"),
        ("Überwachung – grün", "Überwachung – grün"),
    ],
)
def test_no_name_steers_a_terminal_or_breaks_out_of_its_line(name, told):
    assert plain(name) == told


def test_people_read_rounded_numbers_dashes_and_all_lines_of_a_cell():
    table = Table("T", ("g|1", "two\nlines"), [(1.005, None), (0.03333, "a\nb"), (12, "c")])

    assert to_markdown(table).splitlines() == [
        "| g\\|1 | two / lines |",
        "| --- | --- |",
        "| 1.00 | – |",
        "| 0.0333 | a / b |",
        "| 12 | c |",
    ]


def test_the_page_and_a_spreadsheet_get_numbers_as_they_are():
    table = Table("T", ("a", "b"), [(0.1 + 0.2, None)])

    assert to_page(table) == {"title": "T", "header": ["a", "b"], "rows": [(0.1 + 0.2, None)]}
    assert as_csv(table.lines) == b"a,b\n0.30000000000000004,\n"
