"""What is written to sockets: JSON, PNG, CBOR, what ROS nodes send, fragments."""

import json
import struct

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.frames import OP_BINARY, OP_TEXT

from mrsfi_bridge.frames import PLAIN, Encoding, Outgoing, png, text_frames
from tests.support.bridge import TYPES, parse_frames, png_text


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
