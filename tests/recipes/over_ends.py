"""Fly a mission over a transport of the conformance suite, and on the engines.

Run as ``python -m tests.recipes.over_ends MISSION TRANSPORT``; prints each one's digest as JSON.
"""

import json
import sys
from collections.abc import Iterator

from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.conformance.test_transports import TRANSPORTS
from tests.recipes.tree import ENGINES
from tests.support.rosbridge import FLIGHT_SEED, code_of, specification
from tests.support.two_sides import TwoSides

N_TICKS = 40
"""As many as a bus without threads can answer within one call."""


def digests(mission: str, transport: str) -> Iterator[tuple[str, str]]:
    """Yield the names of engines and of the transport with the digest of a flight on each."""
    code = code_of(mission, N_TICKS)
    faults = specification(code, FLIGHT_SEED)

    def digest(engine: Engine) -> str:
        return engine.evaluate(faults).digest

    for name in ENGINES:
        with open_engine(EngineSettings(name), code, 1) as engine:
            yield name, digest(engine)
    with TRANSPORTS[transport]() as (first, second):
        yield transport, digest(TwoSides(code, 1, first, second))
        first.close()
        second.close()


if __name__ == "__main__":
    print(json.dumps(dict(digests(*sys.argv[1:]))))  # noqa: T201 - what it is for
