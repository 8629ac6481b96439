"""`python -m heatlens` is the command `heatlens`."""

import sys

from heatlens.commands.main import main

if __name__ == "__main__":
    sys.exit(main())
