"""The pages of the manual, for tests of what they show."""

import re
from pathlib import Path

MANUAL = Path(__file__).parents[2] / "app" / "manual"
CONTENTS = MANUAL / "README.md"
MADE_PAGES = ("keys", "options")  # by tests/manual_keys.py and tests/manual_options.py


def page(name: str) -> str:
    """Return the text of a page."""
    return (MANUAL / f"{name}.md").read_text(encoding="utf-8")


def written_pages() -> dict[str, str]:
    """Return the text of each page that people write, by name, in the order of the contents."""
    names = dict.fromkeys(re.findall(r"\]\((\w+)\.md\)", CONTENTS.read_text(encoding="utf-8")))
    return {name: page(name) for name in names if name not in MADE_PAGES}


def manual_text() -> str:
    """Return all that people write of the manual."""
    return CONTENTS.read_text(encoding="utf-8") + "\n".join(written_pages().values())
