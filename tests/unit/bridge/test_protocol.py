"""From texts to operations: JSON, several objects in a frame, fragments, levels."""

import json
from contextlib import suppress
from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.protocol import Fragments
from mrsfi_bridge.settings import Limits
from tests.support.bridge import FLOAT, TEXT, Peer, new_hub
from tests.tiers import law, slow


@pytest.fixture
def peer(hub):
    return Peer(hub)


@pytest.fixture
def told(hub):
    """A client that is told of errors."""
    return Peer(hub, "error")


def test_several_objects_may_share_a_frame(peer):
    operations = [
        {"op": "advertise", "topic": "/t", "type": FLOAT},
        {"op": "subscribe", "topic": "/t"},
        {"op": "publish", "topic": "/t", "msg": {"data": 1}},
    ]

    peer.session.receive(" \n".join(map(json.dumps, operations)))

    assert peer.messages() == [{"data": 1.0}]


def test_what_precedes_bad_json_is_carried_out(told, approved):
    told.session.receive('{"op":"advertise","topic":"/t","type":"std_msgs/Bool"}{"op":')

    (status,) = told.take()
    approved(status["msg"])
    told.tell(op="unadvertise", topic="/t")
    assert told.take() == []


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", None),
        ("{", "bad JSON at letter 1 of 1"),
        ("[1, 2]", "expected an object with 'op'"),
        ("5", "found 5, expected an object"),
        ("{}", "unknown op None, expected one of advertise"),
        ('{"op": "fly"}', "unknown op 'fly'"),
        ('{"op": ["fly"]}', "unknown op"),
        ('{"op": "png", "data": ""}', "unknown op 'png'"),
        ("[" * 100_000, "nested too deeply"),
        ('{"op": "advertise", "topic": ' + "9" * 5000 + "}", "bad JSON"),
        ('{"op": "unsubscribe", "topic": "/t", "id": "' + "x" * 300 + '"}', "'id' is longer than"),
        ('{"op": "unsubscribe", "topic": "' + "x" * 9999 + '"}', "topic 'xxx"),
        ('{"op": "set_level", "level": "loud"}', "level 'loud', expected one of info"),
    ],
)
def test_what_is_no_operation_is_counted_and_told_to_those_who_ask(hub, told, text, reason):
    told.session.receive(text)

    statuses = [operation["msg"] for operation in told.take()]
    assert len(statuses) == hub.counts.dropped == (reason is not None)
    assert all(reason in status and len(status) <= 500 for status in statuses)


@given(st.text())
def test_no_text_breaks_a_session(text):
    hub, _ = new_hub()
    peer = Peer(hub)

    peer.session.receive(text)

    assert peer.take() == []


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=5,
)
_FIELDS = ("topic", "type", "msg", "id", "service", "args", "values", "result", "data", "num")
_OPS = (
    "advertise",
    "unadvertise",
    "publish",
    "subscribe",
    "unsubscribe",
    "call_service",
    "service_response",
    "advertise_service",
    "unadvertise_service",
    "set_level",
    "fragment",
)


@slow
@given(
    st.lists(
        st.fixed_dictionaries(
            {"op": st.sampled_from(_OPS)},
            optional={
                name: _VALUES | st.sampled_from(["/t", "t", FLOAT, "std_srvs/Empty"])
                for name in (*_FIELDS, "total", "level", "latch", "throttle_rate", "fragment_size")
            },
        ),
        max_size=8,
    )
)
def test_no_operation_breaks_a_session(operations):
    hub, clock = new_hub()
    peer, bystander = Peer(hub), Peer(hub)
    bystander.tell(op="advertise", topic="/s", type=TEXT)
    bystander.tell(op="subscribe", topic="/s")

    for operation in operations:
        peer.tell(**operation)
    clock.advance(100)
    peer.session.leave()
    bystander.tell(op="publish", topic="/s", msg={"data": "still there"})

    assert bystander.messages()[-1] == {"data": "still there"}


def test_nothing_is_told_unless_a_level_was_set(peer):
    peer.tell(op="fly")
    peer.tell(op="set_level", level="none")
    peer.tell(op="fly")

    assert peer.take() == []


def fragments(text, size, fragment_id="f"):
    parts = [text[start : start + size] for start in range(0, len(text), size)]
    return [
        {"op": "fragment", "id": fragment_id, "data": part, "num": number, "total": len(parts)}
        for number, part in enumerate(parts)
    ]


def test_fragments_are_put_together(peer):
    text = json.dumps({"op": "subscribe", "topic": "/t", "type": FLOAT})
    for fragment in fragments(text, 7):
        peer.tell(**fragment)

    peer.tell(op="publish", topic="/t", msg={"data": 1})

    assert peer.messages() == [{"data": 1.0}]
    assert peer.session.fragments.n_bytes == 0


def test_messages_in_fragments_may_be_mixed():
    collected, done = Fragments(10_000), []
    first, second = fragments("abcdef", 2, 1), fragments("uvwxyz", 2, 2)

    for pair in zip(first, second, strict=True):
        done += [text for fragment in pair if (text := collected.add(fragment)) is not None]

    assert done == ["abcdef", "uvwxyz"]


def completed(collected, *told):
    """Return the texts that fragments complete; those that are refused are left out."""
    done = []
    for fragment in told:
        with suppress(ProtocolError):
            done += [text for text in [collected.add(fragment)] if text is not None]
    return done


@pytest.mark.parametrize(
    ("number", "total"),
    [(2, 2), (-1, 2), (1, 3), (0, 2)],
)
def test_fragments_that_make_no_sense_are_refused_and_forgotten(number, total, refused):
    collected = Fragments(10_000)
    collected.add({"id": "f", "data": "a", "num": 0, "total": 2})

    with refused(ProtocolError):
        collected.add({"id": "f", "data": "b", "num": number, "total": total})

    assert collected.n_bytes == 0


WRONG = {
    "a number too high": {"num": 3},
    "a negative number": {"num": -1},
    "another total": {"total": 4},
    "a number of another kind": {"num": 1.0},
    "a number that is missing": {"num": None},
    "a total of another kind": {"total": "3"},
    "data of another kind": {"data": 7},
    "data that is missing": {"data": None},
    "too much data": {"data": "x" * 3000},
    "the number of another fragment": {"num": 0},
}
"""What makes a fragment of three one that is refused; what is ``None`` is left out."""


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_a_message_of_which_a_fragment_is_refused_leaves_nothing_to_the_next(wrong):
    peer = Peer(new_hub(Limits(frame_bytes=1000))[0])
    peer.tell(op="advertise", topic="/s", type=TEXT)
    peer.tell(op="subscribe", topic="/s")
    one, two, three = (published(word) for word in ("one", "two", "three"))
    changed = {**one[1], **wrong}
    one[1] = {key: value for key, value in changed.items() if value is not None}

    for fragment in (*one, *two, *three):
        peer.tell(**fragment)

    assert peer.messages() in ([{"data": "two"}, {"data": "three"}], [{"data": "three"}])
    assert peer.session.fragments.n_bytes == 0


def published(word):
    """Return three fragments that publish a word."""
    text = json.dumps({"op": "publish", "topic": "/s", "msg": {"data": word}})
    return fragments(text, -(-len(text) // 3))


def test_a_refused_fragment_alone_makes_way_for_a_first_fragment():
    collected = Fragments(10_000)
    _, second, third = fragments("abcdef", 2)

    assert completed(collected, second | {"data": "x" * 10_000}, third) == []
    assert completed(collected, *fragments("uvwxyz", 2)) == ["uvwxyz"]


def test_a_message_that_follows_an_unfinished_one_of_another_length_is_refused_whole():
    collected = Fragments(10_000)
    words = [fragments(f"head of {word}, tail of {word}", 14) for word in ("two", "six", "ten")]
    unfinished = {"id": "f", "data": "head", "num": 0, "total": 4}

    assert completed(collected, unfinished, *chain(*words)) == [
        "head of six, tail of six",
        "head of ten, tail of ten",
    ]


def test_two_messages_at_once_with_one_id_are_both_refused():
    collected = Fragments(10_000)
    mixed = zip(fragments("abcdef", 2), fragments("uvwxyz", 2), strict=True)

    assert completed(collected, *(fragment for pair in mixed for fragment in pair)) == []
    assert completed(collected, *fragments("ghijkl", 2)) == ["ghijkl"]


def test_a_message_refused_for_others_that_are_unfinished_stays_so():
    collected = Fragments(10_000)
    others = [fragments("abcd", 2, number) for number in range(16)]
    completed(collected, *(first for first, _ in others))
    first, second = fragments("uvwx", 2)

    assert completed(collected, first, others[0][1], second) == ["abcd"]
    assert completed(collected, first | {"data": "UV"}, second) == ["UVwx"]


@law(200)
@given(st.lists(st.tuples(st.integers(1, 4), st.sets(st.integers(0, 3))), max_size=8))
def test_what_is_put_together_was_sent_whole(messages):
    collected, sent, done = Fragments(1000), [], []
    for place, (n, refused) in enumerate(messages):
        text = "".join(f"{place}.{number} " for number in range(n))
        if refused.isdisjoint(range(n)):
            sent.append(text)
        wrong = {"data": "x" * 1000}
        told = (f | wrong if f["num"] in refused else f for f in fragments(text, 4))
        done += completed(collected, *told)

    assert done == sent


def test_unfinished_messages_are_bounded_in_number_and_size(refused):
    collected = Fragments(5_000)
    for number in range(16):
        collected.add({"id": number, "data": "a", "num": 0, "total": 2})

    with refused(ProtocolError):
        collected.add({"id": 99, "data": "a", "num": 0, "total": 2})
    with refused(ProtocolError):
        collected.add({"id": 0, "data": "a" * 6_000, "num": 1, "total": 2})


def test_a_fragment_within_fragments_does_not_recurse_without_end(peer):
    text = json.dumps({"op": "set_level", "level": "error"})
    for _ in range(300):
        (fragment,) = fragments(text, len(text))
        text = json.dumps(fragment)[:900_000]
        if len(text) > 500_000:
            break

    peer.session.receive(text)

    assert peer.take() == []


def test_limits_of_a_client_bound_its_fragments(approved):
    hub, _ = new_hub(Limits(frame_bytes=1000))
    peer = Peer(hub, "error")

    peer.tell(op="fragment", id="f", data="x" * 3000, num=0, total=2)

    approved(peer.take()[0]["msg"])
