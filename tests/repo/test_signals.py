"""Test that programs started by tests obey signals, also under nohup and in the background."""

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


def ignore_signals(*signals: signal.Signals):
    def ignore() -> None:
        for number in signals:
            signal.signal(number, signal.SIG_IGN)

    return ignore


def test_child_processes_do_not_inherit_ignored_signals(tmp_path):
    (tmp_path / "test_it.py").write_text(f"CHILD = {CHILD!r}\n{TEST}")
    folder = os.path.dirname(os.path.dirname(__file__))
    root = os.path.dirname(folder)
    line = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c"]
    line += [f"{root}/pyproject.toml", "--rootdir", root, "-p", "conftest", str(tmp_path)]
    process = subprocess.run(
        line,
        preexec_fn=ignore_signals(signal.SIGHUP, signal.SIGINT, signal.SIGQUIT),
        env=os.environ | {"PYTHONPATH": folder},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
