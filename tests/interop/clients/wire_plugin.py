"""Has roslibpy's own tests use our client, in the place of the one that it would choose."""

import roslibpy.ros

from mrsfi_runtime.transport.wire import WireFactory

roslibpy.ros.select_factory = lambda _: WireFactory
