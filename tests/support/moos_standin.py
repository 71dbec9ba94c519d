"""Stands for MOOS and UNDERSEA in tests: a community with a vehicle that obeys at once.

``python moos_standin.py FILE.moos --alias=MOOSDB`` serves the wire protocol of MOOS, by the packets
of pymoos2. Ten times in a second of MOOS time it moves the vehicle and publishes where it is. Under
another alias it is an sSensor, whose readings are good and bad in turn.
"""

import math
import re
import socket
import sys
import threading
from itertools import count
from pathlib import Path

from pymoos2.core import constants
from pymoos2.core.MOOSCommClient import MOOSCommClient
from pymoos2.core.MOOSCommPkt import pack, unpack
from pymoos2.core.MOOSMsg import MOOSMsg
from pymoos2.core.time import moos_pause, moos_time, set_moos_time_warp

STEP_S = 0.1


class Community:
    """A vehicle, and the mail of its clients."""

    def __init__(self, text: str) -> None:
        told = dict(re.findall(r"^\s*(\w+) *= *(\S+)$", text, re.M))
        x, y = re.search(r"x=(\S+), y=(\S+),", text).groups()
        self.port = int(told["ServerPort"])
        set_moos_time_warp(float(told["MOOSTimeWarp"]))
        self.lock = threading.Lock()
        self.mail = []
        self.x, self.y, self.heading, self.speed = float(x), float(y), 0.0, 0.0

    def obey(self, message: MOOSMsg) -> None:
        """Take in a message of a client, or pass it on to all."""
        if message.key == "DESIRED_SPEED":
            self.speed = message.val
        elif message.key == "DESIRED_HEADING":
            self.heading = math.radians(message.val)
        elif message.key == "USM_RESET":
            told = dict(each.split("=") for each in message.string().split(","))
            self.x, self.y, self.speed = float(told["x"]), float(told["y"]), 0.0
        elif message.key.startswith("SENSOR"):
            for mailbox in self.mail:
                mailbox.append(message)

    def live(self) -> None:
        """Move, and publish, for ever."""
        due = moos_time()
        while True:
            due += STEP_S
            moos_pause(1000.0 * max(due - moos_time(), 0.0))
            with self.lock:
                self.x += STEP_S * self.speed * math.sin(self.heading)
                self.y += STEP_S * self.speed * math.cos(self.heading)
                for name in ("x", "y", "speed"):
                    value = getattr(self, name)
                    message = MOOSMsg(constants.MSG_NOTIFY, f"NAV_{name.upper()}", value, time=due)
                    for mailbox in self.mail:
                        mailbox.append(message)

    def serve(self, client: socket.socket) -> None:
        """Answer each packet of a client by its mail."""
        with client, client.makefile("rwb") as stream:
            stream.read(constants.PROTOCOL_STRING_BUFFER_SIZE)
            mailbox: list[MOOSMsg] = [MOOSMsg(constants.MSG_WELCOME)]
            with self.lock:
                self.mail.append(mailbox)
            while header := stream.read(4):
                packet = header + stream.read(int.from_bytes(header, "little") - 4)
                with self.lock:
                    for message in unpack(packet):
                        self.obey(message)
                    answer, mailbox[:] = [*mailbox], []
                stream.write(pack(answer or [MOOSMsg(constants.MSG_NULL)]))
                stream.flush()


def measure(community: Community, name: str, rate: float) -> None:
    """Publish readings at a rate, for ever."""
    client = MOOSCommClient("localhost", community.port, name, rate)
    client.start()
    for n in count():
        client.notify(name, float(n % 2))
        moos_pause(1000.0 / rate)


if __name__ == "__main__":
    text, alias = Path(sys.argv[1]).read_text(encoding="utf-8"), sys.argv[2].split("=")[1]
    community = Community(text)
    if alias != "MOOSDB":
        block = text[text.index(f"NAME        = {alias}") :]
        measure(community, alias, float(re.search(r"AppTick += (\S+)", block)[1]))
    server = socket.create_server(("localhost", community.port))
    threading.Thread(target=community.live, daemon=True).start()
    while True:
        accepted, _ = server.accept()
        threading.Thread(target=community.serve, args=(accepted,), daemon=True).start()
