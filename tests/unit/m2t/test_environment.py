"""Filters through which model text reaches code."""

import ast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import UndefinedError

from m2t.emit import Call, Table, expression, literal, remark, template_environment

SCALARS = st.one_of(
    st.text(),
    st.integers(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.booleans(),
    st.none(),
)
VALUES = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=4).map(tuple), max_leaves=8)
HOSTILE = (
    'x"); import os; os.system("touch owned")  #\n\'{{ 7*7 }}{% raw %}\\ # noqa\u202e\x00\ud800'
)


@given(VALUES)
def test_literal_evaluates_to_the_value(value):
    text = literal(value)

    found = ast.literal_eval(text)

    assert found == value
    assert repr(found) == repr(value)
    assert text.isascii()
    assert "\n" not in text


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("LEN", '"LEN"'),
        ("don't", '"don\'t"'),
        ('say "go"', "'say \"go\"'"),
        ("Zoë", '"Zo\\xeb"'),
        (5.0, "5.0"),
        (1e22, "1e22"),
        (-0.0, "-0.0"),
        (True, "True"),
        (None, "None"),
        ((), "()"),
        (("r2",), '("r2",)'),
        (("r2", 3), '("r2", 3)'),
    ],
)
def test_literal_is_written_as_a_formatter_writes_it(value, expected):
    assert literal(value) == expected


@pytest.mark.parametrize("value", [float("nan"), float("inf"), (1.0, float("-inf"))])
def test_number_that_is_not_finite_has_no_literal(value):
    with pytest.raises(ValueError, match="finite"):
        literal(value)


def test_other_types_have_no_literal():
    with pytest.raises(TypeError, match="object"):
        literal(object())


@given(st.one_of(st.text(), st.just(HOSTILE)))
def test_remark_is_one_short_line_of_ascii(text):
    found = remark(text)

    assert found.isascii()
    assert found.isprintable()
    assert "#" not in found
    assert len(found) <= 40


@pytest.mark.parametrize("text", ["LEN", "uuv_sampling", "1000", "Scout-1"])
def test_plain_word_stays_as_it_is_in_a_comment(text):
    assert remark(text) == text


@pytest.mark.parametrize("text", ["noqa", "NOQA", "", "two words", "type: ignore"])
def test_other_text_is_quoted_in_a_comment(text):
    assert remark(text) == ascii(text)


def test_expression_has_one_argument_a_line():
    robot = Call(
        "Robot",
        (
            ("id", "r1"),
            ("position", Call("Coordinates", (("x", 1.0), ("y", 2.0)), is_flat=True)),
            ("sensors", (Call("Sensor", (("id", "s1"),)), Call("Sensor", (("id", "s2"),)))),
            ("members", ("r2", "r3")),
            ("task", Call("SufficientEnergy")),
            ("bounds", Table((("P", (None, 10.0)),))),
            ("properties", ()),
        ),
    )

    text = expression(robot)

    assert text == (
        "Robot(\n"
        '    id="r1",\n'
        "    position=Coordinates(x=1.0, y=2.0),\n"
        "    sensors=(\n"
        "        Sensor(\n"
        '            id="s1",\n'
        "        ),\n"
        "        Sensor(\n"
        '            id="s2",\n'
        "        ),\n"
        "    ),\n"
        '    members=("r2", "r3"),\n'
        "    task=SufficientEnergy(),\n"
        '    bounds={"P": (None, 10.0)},\n'
        "    properties=(),\n"
        ")"
    )


def test_undefined_name_in_a_template_is_an_error():
    template = template_environment().from_string("{{ robots }}")

    with pytest.raises(UndefinedError):
        template.render()


def test_template_syntax_in_a_value_is_not_rendered():
    template = template_environment().from_string("{{ name | literal }}")

    assert ast.literal_eval(template.render(name=HOSTILE)) == HOSTILE
