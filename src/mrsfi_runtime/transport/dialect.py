"""What ROS 1 and ROS 2 write in two ways: names of types, and times."""

from mrsfi_runtime.transport.topics import Payload

ROS_VERSIONS = (1, 2)


def type_name(name: str, kind: str, ros: int) -> str:
    """Return the name of a type, ``PACKAGE/TYPE``, as a version of ROS spells it."""
    return name if ros == 1 else name.replace("/", f"/{kind}/")


def time_of(tick: int, ros: int) -> Payload:
    """Return the time of a tick: one tick is one second."""
    return {"secs": tick, "nsecs": 0} if ros == 1 else {"sec": tick, "nanosec": 0}


def seconds_of(time: Payload) -> int:
    """Return the seconds of a time, of either version."""
    seconds: int = time["sec"] if "sec" in time else time["secs"]
    return seconds
