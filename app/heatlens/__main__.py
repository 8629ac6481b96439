"""The entry point of `python -m heatlens` and of the command `heatlens`."""

# A built-in module, which is available before `signal` has been loaded from disk.
import _signal  # type: ignore[import-not-found]
import os
import sys

if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
    # Ctrl-C in the first milliseconds ends the process silently; later `launch` handles it.
    _signal.signal(_signal.SIGINT, lambda *_: os._exit(128 + _signal.SIGINT))

from heatlens.fronts.commands.launch import main

if __name__ == "__main__":
    sys.exit(main())
