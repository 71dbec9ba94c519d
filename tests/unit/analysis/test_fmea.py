"""What a table of failure modes says, where nobody looks at it as one."""

from mrsfi_runtime.analysis.weaknesses import FailureMode, modes_as_csv, modes_as_markdown


def test_no_cell_is_a_formula_in_a_spreadsheet_or_markup_on_a_page():
    texts = (7, "f9", "listed", "-a", "b|c", "<d", "=1+1 (g1)", "true", "no", "violated")
    modes = [FailureMode(*texts, 3, chance) for chance in (0.1 * 0.2, None)]

    table = modes_as_csv("harbour", modes).decode().splitlines()
    page = modes_as_markdown("har|bour", modes).decode().splitlines()

    assert table[0] == ",".join(FailureMode._fields)
    assert table[2] == "7,f9,listed,'-a,b|c,<d,'=1+1 (g1),true,no,violated,3,"
    assert page[0] == "# Failure modes of mission har\\|bour"
    told = "| 7 | f9 | listed | -a | b\\|c | &lt;d | =1+1 (g1) | true | no | violated | 3 | "
    assert page[-2:] == [f"{told}0.02 |", f"{told}– |"]
