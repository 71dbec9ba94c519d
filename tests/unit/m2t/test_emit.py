"""Generated text: filters, protected regions and the manifest."""

import ast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import UndefinedError

from m2t.emit import (
    Call,
    FileRecord,
    Table,
    dumps,
    expression,
    is_hand_written,
    literal,
    loads,
    merge,
    parse,
    record_of,
    remark,
    template_environment,
)
from mrsfi_runtime.errors import GenerationError, ProtectedRegionError

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
GENERATED = """# Generated
import tasks

# protected region imports on begin
# protected region imports end


def check_g1(ci):
    # protected region g1.check on begin
    return tasks.violated(ci)
    # protected region g1.check end
"""
RECORD = record_of(parse(GENERATED, "ci.py"))
WORDS = st.text(st.characters(exclude_characters="/\\", exclude_categories=["Cs"]), min_size=1)
RECORDS = st.builds(FileRecord, WORDS, st.dictionaries(WORDS, WORDS, max_size=3))
FILES = st.dictionaries(WORDS.filter(lambda name: name not in {".", ".."}), RECORDS, max_size=3)


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


def edited(old: str, new: str, text: str = GENERATED) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


def merged(existing: str, *, generated: str = GENERATED, record=RECORD, force=False) -> str:
    return merge(parse(generated, "new"), parse(existing, "ci.py"), record, force=force)


def test_regions_are_found_with_bodies_and_lines():
    document = parse(GENERATED, "ci.py")

    found = [
        (region.id, region.is_on, region.body, region.line) for region in document.regions.values()
    ]

    assert found == [
        ("imports", True, "", 4),
        ("g1.check", True, "    return tasks.violated(ci)\n", 9),
    ]


LINES = st.text(st.characters(exclude_characters="\n#", exclude_categories=["Cs"]), max_size=10)


BODIES = st.lists(LINES, max_size=3).map(lambda lines: "".join(f"{line}\n" for line in lines))


@st.composite
def documents(draw) -> str:
    parts = [draw(BODIES)]
    for index in range(draw(st.integers(0, 3))):
        indent = draw(st.sampled_from(["", "    ", "\t"]))
        state = draw(st.sampled_from(["on", "off"]))
        parts += [
            f"{indent}# protected region r{index} {state} begin\n",
            draw(BODIES),
            f"{indent}# protected region r{index} end\n",
            draw(BODIES),
        ]
    return "".join(parts) + draw(LINES)


@given(documents())
def test_parsed_document_has_the_text_it_was_parsed_from(text):
    assert parse(text, "x").text == text


@given(documents())
def test_merge_of_a_file_with_itself_changes_nothing(text):
    document = parse(text, "x")

    assert merge(document, document, record_of(document)) == text
    assert merge(document, document, None) == text
    assert not is_hand_written(document, record_of(document))


@given(documents(), st.data())
def test_edited_bodies_of_regions_that_are_on_survive_and_nothing_else_changes(text, data):
    document = parse(text, "x")
    rewritten = text
    for region in document.regions.values():
        if region.is_on:
            body = data.draw(BODIES)
            rewritten = rewritten.replace(region.text, region.begin + body + region.end)

    found = merge(document, parse(rewritten, "x"), record_of(document))

    assert found == rewritten


NESTED = """# protected region a on begin
# protected region b on begin
# protected region b end
# protected region a end
"""


DOUBLED = """# protected region a on begin
# protected region a end
# protected region a off begin
# protected region a end
"""


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("# protected region a on begin\n", 1),
        ("x\n# protected region a end\n", 2),
        (NESTED, 2),
        ("# protected region a on begin\n# protected region b end\n", 2),
        (DOUBLED, 3),
        ("x\ny\n# protected region a begin\n", 3),
        ("#protected  region a on begin\n", 1),
        ("# Protected Region a end\n", 1),
    ],
)
def test_broken_markers_are_errors_with_file_and_line(text, line, refused):
    with refused(ProtectedRegionError) as caught:
        parse(text, "g/ci.py")

    assert str(caught.value).startswith(f"g/ci.py:{line}: ")


def test_marker_inside_a_line_of_code_is_no_marker():
    text = 'name = "# protected region a on begin"  # protected region a end\n'

    assert not parse(text, "x").regions


OTHER_BODY = edited("tasks.violated(ci)", "tasks.violated(ci, G1)")


BY_HAND = edited("    return tasks.violated(ci)\n", "    return False\n")


OFF = edited("g1.check on", "g1.check off")


WITHOUT_G1 = GENERATED[: GENERATED.index("\n\ndef check_g1")]


@pytest.mark.parametrize(
    ("existing", "generated", "record", "expected"),
    [
        (GENERATED, OTHER_BODY, RECORD, OTHER_BODY),
        (
            BY_HAND,
            edited("# Generated\n", "# Generated anew\n"),
            RECORD,
            edited("# Generated\n", "# Generated anew\n", BY_HAND),
        ),
        (GENERATED, OTHER_BODY, None, GENERATED),
        (OFF, OTHER_BODY, RECORD, edited("g1.check on", "g1.check off", OTHER_BODY)),
        (GENERATED, WITHOUT_G1, RECORD, WITHOUT_G1),
        (edited("    return tasks.violated(ci)\n", "\n"), WITHOUT_G1, RECORD, WITHOUT_G1),
    ],
    ids=[
        "a body that nobody edited is generated anew",
        "an edited body is kept while the skeleton is renewed",
        "without a manifest every body counts as edited",
        "a region that is off is overwritten",
        "an orphaned region that nobody edited goes",
        "an orphaned region that was emptied goes",
    ],
)
def test_what_is_there_and_what_is_generated_are_merged(existing, generated, record, expected):
    assert merged(existing, generated=generated, record=record) == expected


EDITED = edited("tasks.violated(ci)", "False")


EDITED_OUTSIDE = edited("import tasks", "import tasks, os")


OTHER_IMPORT = edited("import tasks", "import kernel")


MINE = "# protected region mine on begin\nx = 1\n# protected region mine end\n"


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize(
    ("existing", "more"),
    [(edited("g1.check on", "g1.check off", EDITED), {}), (EDITED, {"generated": WITHOUT_G1})],
    ids=["off", "gone"],
)
def test_edited_code_that_would_be_lost_stops_generation(existing, more, force, refused):
    with refused(ProtectedRegionError):
        merged(existing, force=force, **more)


@pytest.mark.parametrize(
    ("existing", "more"),
    [
        (OFF, {"generated": OTHER_BODY, "record": None}),
        (EDITED_OUTSIDE, {}),
        (GENERATED, {"generated": OTHER_IMPORT, "record": None}),
        (GENERATED + MINE, {}),
    ],
    ids=["off", "outside", "no manifest", "unknown"],
)
def test_what_would_be_lost_stops_generation(existing, more, refused):
    with refused(ProtectedRegionError):
        merged(existing, **more)


@pytest.mark.parametrize(
    ("existing", "more", "expected"),
    [
        (EDITED_OUTSIDE, {}, GENERATED),
        (edited("import tasks", "import os", EDITED), {}, EDITED),
        (GENERATED, {"generated": OTHER_IMPORT, "record": None}, OTHER_IMPORT),
    ],
)
def test_forced_generation_replaces_all_but_edited_regions(existing, more, expected):
    assert merged(existing, force=True, **more) == expected


@given(st.dictionaries(WORDS, WORDS, max_size=3), FILES)
def test_what_a_manifest_remembers_survives_a_round_trip(sources, files):
    read = loads(dumps(sources, files), "m")

    assert read == files


def test_text_does_not_depend_on_the_order_of_entries():
    first = dumps({"a": "x", "b": "y"}, {})

    assert first == dumps({"b": "y", "a": "x"}, {})
    assert first.endswith("}\n")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"schema": 1}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": []}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": {"a.py": {"skeleton": "x"}}}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": {"a.py": [{"regions": {}}]}}',
        '{"schema": "one", "generator": "1", "sources": {}, "files": {}}',
        '{"schema": 1, "generator": "1", "sources": {}, "files": {"../a.py": null}}',
        "[" * 100_000,
    ],
)
def test_what_is_no_manifest_is_refused(text):
    with pytest.raises(GenerationError):
        loads(text, "g/manifest.json")


def test_manifest_of_a_newer_version_is_refused(refused):
    text = dumps({}, {}).replace('"schema": 1', '"schema": 2')

    with refused(GenerationError):
        loads(text, "m")
