"""From frames to operations, and back: texts, encodings, fragments, levels, settings."""

import json
import struct
from contextlib import suppress
from itertools import chain

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.frames import OP_BINARY, OP_TEXT

from mrsfi_bridge.errors import ProtocolError, SettingsError
from mrsfi_bridge.frames import PLAIN, Encoding, Outgoing, png, text_frames
from mrsfi_bridge.protocol import Fragments
from mrsfi_bridge.server import ROUNDS, Barriers
from mrsfi_bridge.settings import Limits, ServerSettings
from tests.support.bridge import FLOAT, TEXT, TYPES, Peer, new_hub, parse_frames, png_text
from tests.tiers import law, slow

TOKEN = "0123456789abcdef"


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
        ("{", "bad JSON at character 1 of 1"),
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


def outgoing(type_name, message):
    structure = TYPES.message(type_name)
    return Outgoing(structure, structure.convert(message))


def binary(type_name, message, compression):
    (frame,) = parse_frames(outgoing(type_name, message).frames("/t", Encoding(compression)))
    assert frame.opcode is OP_BINARY
    return cbor2.loads(frame.data)


@pytest.mark.parametrize("size", [0, 125, 126, 65_535, 65_536])
def test_frames_of_every_length_are_well_formed(size):
    text = "x" * size
    content = outgoing("std_msgs/String", {"data": text}).frames("/t", PLAIN)

    (frame,) = parse_frames(content)

    assert frame.opcode is OP_TEXT
    assert json.loads(frame.data) == {"op": "publish", "topic": "/t", "msg": {"data": text}}


def test_what_is_no_number_becomes_null():
    message = {"x": float("nan"), "y": float("inf"), "z": 0.1}
    (frame,) = parse_frames(outgoing("geometry_msgs/Point", message).frames("/t", PLAIN))

    assert json.loads(frame.data)["msg"] == {"x": None, "y": None, "z": 0.1}


def test_a_message_is_encoded_once_for_all_who_want_the_same():
    message = outgoing("std_msgs/String", {"data": "a"})

    assert message.frames("/t", PLAIN) is message.frames("/t", Encoding("none", None))


@given(st.text(min_size=0, max_size=3000))
def test_pixels_spell_the_text_padded_with_newlines(text):
    assert png_text(png(text.encode())).rstrip("\n") == text.rstrip("\n")


def test_png_carries_the_operation():
    (frame,) = parse_frames(outgoing("std_msgs/Bool", {"data": True}).frames("/t", Encoding("png")))
    operation = json.loads(frame.data)

    assert operation["op"] == "png"
    assert json.loads(png_text(operation["data"])) == {
        "op": "publish",
        "topic": "/t",
        "msg": {"data": True},
    }


@given(st.text(max_size=300), st.integers(1, 50))
def test_fragments_put_together_are_the_operation(text, size):
    operation = {"op": "status", "level": "info", "msg": f"a text of some length: {text}"}

    fragments = [
        json.loads(f.data) for f in parse_frames(text_frames(operation, Encoding("none", size)))
    ]

    assert {f["op"] for f in fragments} == {"fragment"}
    assert {f["total"] for f in fragments} == {len(fragments)}
    assert len({f["id"] for f in fragments}) == 1
    assert all(len(f["data"]) <= size for f in fragments)
    parts = {f["num"]: f["data"] for f in fragments}
    assert json.loads("".join(parts[n] for n in range(len(fragments)))) == operation


def test_what_fits_is_not_cut_into_fragments():
    (frame,) = parse_frames(text_frames({"op": "status"}, Encoding("none", 1000)))

    assert json.loads(frame.data) == {"op": "status"}


def test_tiny_fragments_do_not_multiply_the_traffic_without_bound():
    frames = parse_frames(text_frames({"msg": "x" * 100_000}, Encoding("none", 1)))

    assert len(frames) <= 4096


def test_cbor_has_typed_arrays_and_bytes():
    assert binary("sensor_msgs/JointState", {"name": ["a"], "position": [1, 2.5]}, "cbor")["msg"][
        "position"
    ] == cbor2.CBORTag(86, struct.pack("<2d", 1.0, 2.5))
    assert binary("sensor_msgs/Image", {"data": [1, 2, 255]}, "cbor")["msg"]["data"] == b"\1\2\xff"
    assert binary("sensor_msgs/Joy", {"buttons": [-1]}, "cbor")["msg"]["buttons"] == cbor2.CBORTag(
        78, struct.pack("<i", -1)
    )


def test_cbor_has_messages_as_maps_and_lists_of_them():
    path = binary("nav_msgs/Path", {"header": {"stamp": {"secs": 7}}, "poses": [{}]}, "cbor")

    assert path["op"] == "publish"
    assert path["msg"]["header"]["stamp"] == {"secs": 7, "nsecs": 0}
    assert path["msg"]["poses"][0]["pose"]["position"] == {"x": 0.0, "y": 0.0, "z": 0.0}


@pytest.mark.parametrize(
    ("type_name", "message", "expected"),
    [
        ("std_msgs/Float64", {"data": 1.5}, struct.pack("<d", 1.5)),
        ("std_msgs/Bool", {"data": True}, b"\1"),
        ("std_msgs/String", {"data": "né"}, struct.pack("<I", 3) + "né".encode()),
        ("std_msgs/Time", {"data": {"secs": 1, "nsecs": 2}}, struct.pack("<II", 1, 2)),
        ("std_msgs/Duration", {"data": {"secs": -1, "nsecs": 2}}, struct.pack("<ii", -1, 2)),
        ("geometry_msgs/Point", {"x": 1, "y": 2, "z": 3}, struct.pack("<3d", 1, 2, 3)),
        ("std_msgs/Float32", {"data": 1e300}, struct.pack("<f", float("inf"))),
        (
            "sensor_msgs/Joy",
            {"header": {"seq": 9, "stamp": {}, "frame_id": "f"}, "axes": [0.5], "buttons": [1, 2]},
            struct.pack("<IIII1sIfIii", 9, 0, 0, 1, b"f", 1, 0.5, 2, 1, 2),
        ),
        ("geometry_msgs/Polygon", {"points": [{"x": 1}]}, struct.pack("<Ifff", 1, 1, 0, 0)),
        ("std_msgs/UInt8MultiArray", {"data": [1, 2]}, struct.pack("<III2B", 0, 0, 2, 1, 2)),
        (
            "sensor_msgs/JointState",
            {"header": {"stamp": {}}, "name": ["ab"]},
            struct.pack("<IIIIII2sIII", 0, 0, 0, 0, 1, 2, b"ab", 0, 0, 0),
        ),
    ],
)
def test_cbor_raw_carries_the_bytes_that_ros_nodes_exchange(type_name, message, expected):
    raw = binary(type_name, message, "cbor-raw")["msg"]

    assert raw["bytes"] == expected
    assert raw["secs"] > 1_600_000_000


@pytest.mark.parametrize(
    "settings",
    [
        *map(ServerSettings, ("127.0.0.1", "localhost", "::1", "127.8.0.1")),
        ServerSettings("0.0.0.0", is_public=True, token=TOKEN),
    ],
)
def test_addresses_of_this_machine_need_nothing_and_others_a_flag_and_a_token(settings):
    settings.check()


@pytest.mark.parametrize(
    "settings",
    [
        ServerSettings("0.0.0.0"),
        ServerSettings("::"),
        ServerSettings("robot.example"),
        ServerSettings("0.0.0.0", token=TOKEN),
        ServerSettings("0.0.0.0", is_public=True),
        ServerSettings("0.0.0.0", is_public=True, token="short"),
        ServerSettings(token="0123456789abcde?"),
    ],
)
def test_other_addresses_without_them_are_refused(settings, refused):
    with refused(SettingsError):
        settings.check()


def test_a_token_is_not_printed():
    assert TOKEN not in repr(ServerSettings(token=TOKEN))


class Loop:
    """Calls what it was given when it is asked to."""

    def __init__(self):
        self.waiting = []

    def call_soon(self, function, *arguments):
        self.waiting.append((function, arguments))

    def run(self):
        waiting, self.waiting = self.waiting, []
        for function, arguments in waiting:
            function(*arguments)


class Client:
    """Keeps the pings that it got."""

    def __init__(self):
        self.pings = []

    def ping(self, content):
        self.pings.append(content)


def test_all_clients_answer_every_round():
    barriers, done = Barriers(Loop(), lambda: True), []
    first, second = Client(), Client()
    barriers.begin(lambda: [first, second], lambda: done.append(True))

    for number in range(ROUNDS):
        assert len(first.pings) == len(second.pings) == number + 1
        barriers.pong(first, first.pings[-1])
        barriers.pong(first, first.pings[-1])
        assert not done
        barriers.pong(second, second.pings[-1])
    assert done == [True]


def test_none_is_waited_for_that_has_left_and_nobody_answers_where_nobody_is():
    barriers, done = Barriers(Loop(), lambda: True), []
    first, second = Client(), Client()
    clients = [first, second]
    barriers.begin(lambda: clients, lambda: done.append("one is left"), 1)
    clients = [first]
    barriers.gone(second)
    barriers.pong(first, first.pings[-1])
    barriers.begin(lambda: clients, lambda: done.append("none is left"), 1)
    clients = []
    barriers.gone(first)

    assert done == ["one is left"]


def test_a_pong_that_answers_no_barrier_changes_nothing():
    barriers, done = Barriers(Loop(), lambda: True), []
    client = Client()
    barriers.begin(lambda: [client], lambda: done.append(True), rounds=1)
    barriers.pong(client, b"")  # of a ping that was to see whether it lives

    assert not done
    barriers.pong(client, client.pings[-1])
    assert done


def test_pings_go_behind_what_waits_for_its_turn():
    loop, is_idle, client = Loop(), False, Client()
    barriers = Barriers(loop, lambda: is_idle)
    barriers.begin(lambda: [client], lambda: None)

    loop.run()
    assert not client.pings
    is_idle = True
    loop.run()
    assert len(client.pings) == 1
