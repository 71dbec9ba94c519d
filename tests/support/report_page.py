"""What a page of results shows, as its script reads it."""

import json
import re
import zlib
from base64 import b64decode


def data_of(path):
    """Return the values of a page."""
    text = path.read_text(encoding="utf-8")
    return json.loads(
        re.search('<script type="application/json" id="data">(.*?)</script>', text)[1]
    )


def unpacked(text):
    """Return values that the script reads when they are shown."""
    return json.loads(zlib.decompress(b64decode(text)))
