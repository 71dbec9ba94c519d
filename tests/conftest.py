"""One folder for what tests compile, kept from run to run; Ctrl-C as whoever types it has it."""

import os
import signal
from pathlib import Path

os.environ.setdefault("MRSFI_CACHE", str(Path(__file__).parent.parent / ".pytest_cache" / "mrsfi"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a shell's background, and inherited
    signal.signal(signal.SIGINT, signal.default_int_handler)
