"""Names that are more than names where a table or a report shows them."""

import pytest

from mrsfi_runtime.analysis.table import as_csv, plain


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
