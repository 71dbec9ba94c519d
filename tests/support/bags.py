"""Bags, written of flights and read back by an independent library."""

from collections import defaultdict
from io import BytesIO

from rosbags.highlevel import AnyReader

from mrsfi_runtime.record.observers import Bag, Events, named_faults


def bagged(engine, specification):
    """Return the bag of a flight."""
    mission = engine.code.mission
    faults = named_faults(mission, engine.code.pool, specification)
    stream, tallies = BytesIO(), []
    bag = Bag(mission, stream, faults, Events(mission, faults, tallies))
    engine.evaluate(specification, observer=bag, tallies=tallies)
    bag.finish()
    return stream.getvalue()


def read_bag(path):
    """Return what is on each topic, in its order: time in nanoseconds, and message."""
    found = defaultdict(list)
    with AnyReader([path]) as reader:
        for connection, time, raw in reader.messages():
            found[connection.topic].append((time, reader.deserialize(raw, connection.msgtype)))
    return dict(found)
