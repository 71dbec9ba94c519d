"""Write the glossary into a page of text.

Examples
--------
``python -m docs.glossary docs/glossary.md``
"""

import sys
from pathlib import Path

from mrsfi_runtime.glossary import TERMS

HEAD = """# Glossary

Every term of mrsfi, in the order in which a reader needs them. After a change of
`src/mrsfi_runtime/glossary.py`, write this page anew:
`python -m docs.glossary docs/glossary.md`.
"""


def glossary_page() -> str:
    """Return the page, in Markdown: a section a term."""
    return HEAD + "".join(
        f"\n## {term.name}\n\n{term.meaning}\n\n"
        f"- Example: {term.example}\n- In the field: {term.neighbour}\n"
        for term in TERMS
    )


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(glossary_page(), "utf-8", newline="\n")
