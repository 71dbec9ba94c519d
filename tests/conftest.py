"""One folder for what tests compile, kept from run to run."""

import os
from pathlib import Path

os.environ.setdefault("MRSFI_CACHE", str(Path(__file__).parent.parent / ".pytest_cache" / "mrsfi"))
