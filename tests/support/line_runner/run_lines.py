"""Run command lines in this process: lists of words as JSON in, code and output of each out."""

import contextlib
import io
import json
import sys

from heatlens.fronts.commands.main import main


def run(words: list[str]) -> tuple[int, str, str]:
    """Return the exit code, standard output and standard error of a command line."""
    output, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
        try:
            code = main(words)
        except SystemExit as end:  # --help and --version
            code = int(end.code or 0)
    return code, output.getvalue(), errors.getvalue()


if __name__ == "__main__":
    json.dump([run(words) for words in json.load(sys.stdin)], sys.stdout)
