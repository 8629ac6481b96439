"""The tests start programs that obey signals, also under nohup and in the background."""

import os
import signal
import subprocess
import sys

CHILD = """
from signal import SIG_IGN, Signals, getsignal
print([it.name for it in Signals if getsignal(it) is SIG_IGN])
"""
TEST = """
import subprocess, sys
def test_child():
    said = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True).stdout
    assert "SIGHUP" not in said and "SIGINT" not in said and "SIGQUIT" not in said, said
"""


def ignored(*signals: signal.Signals):
    def ignore() -> None:
        for number in signals:
            signal.signal(number, signal.SIG_IGN)

    return ignore


def test_what_the_tests_start_hears_signals_that_they_ignore(tmp_path):
    (tmp_path / "test_it.py").write_text(f"CHILD = {CHILD!r}\n{TEST}")
    folder = os.path.dirname(os.path.dirname(__file__))
    root = os.path.dirname(folder)
    line = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c"]
    line += [f"{root}/pyproject.toml", "--rootdir", root, "-p", "conftest", str(tmp_path)]
    done = subprocess.run(
        line,
        preexec_fn=ignored(signal.SIGHUP, signal.SIGINT, signal.SIGQUIT),
        env=os.environ | {"PYTHONPATH": folder},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
