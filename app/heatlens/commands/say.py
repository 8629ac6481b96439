"""What a command says: its result, and sentences beside it."""

import sys

from heatlens.printable import printable


def tell(text: str, keep: str = "") -> None:
    """Print a result on stdout, at once; what would steer a terminal is written out, but `keep`."""
    print(printable(text, keep), flush=True)


def say(*sentences: str) -> None:
    """Each on a line of its own on stderr, at once: what follows may take minutes."""
    for sentence in sentences:
        print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
