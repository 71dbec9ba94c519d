"""One HTML file with all that it shows, which asks the network for nothing.

What comes of a model or a record is data: JSON in which no character can end the element that
holds it, and which the page's own script turns into text, never into markup. The content security
policy allows that script and those styles alone, by their hashes.
"""

import json
import re
from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from importlib.resources import files
from typing import Any

_STYLES = ("uPlot.css", "page.css")
_SCRIPTS = ("uPlot.js", "build.js", "flight.js", "screen.js", "page.js")
_UNSAFE = {ord(character): f"\\u{ord(character):04x}" for character in "<>&\u2028\u2029"}


def document(content: Mapping[str, Any]) -> str:
    """Return the page that shows some content: plain values, as ``page.js`` reads them."""
    styles, scripts = ("\n".join(map(_asset, names)) for names in (_STYLES, _SCRIPTS))
    policy = (
        f"default-src 'none'; script-src '{_hash(scripts)}'; style-src '{_hash(styles)}'; "
        "base-uri 'none'; form-action 'none'"
    )
    data = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    parts = {
        "policy": policy,
        "styles": f"<style>{styles}</style>",
        "data": f'<script type="application/json" id="data">{data.translate(_UNSAFE)}</script>',
        "scripts": f"<script>{scripts}</script>",
    }
    return re.sub(r"\{\{(\w+)}}", lambda found: parts[found[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"
