"""What a command says beside its result."""

import sys

from heatlens.printable import printable


def say(*sentences: str) -> None:
    """Each on a line of its own on stderr, at once: what follows may take minutes."""
    for sentence in sentences:
        print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
