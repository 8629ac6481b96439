"""`python -m heatlens` is the command `heatlens`, which also begins here."""

# A part of the interpreter, there before `signal` has read its files.
import _signal  # type: ignore[import-not-found]
import os
import sys

if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
    # Ctrl-C in the first milliseconds ends this in silence; from then on `launch` answers it.
    _signal.signal(_signal.SIGINT, lambda *_: os._exit(128 + _signal.SIGINT))

from heatlens.commands.launch import main

if __name__ == "__main__":
    sys.exit(main())
