"""Random input in the window for a short time; `tests/fuzz/monkey.py` runs it for longer."""

from fuzz.monkey import play
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import QUICK


def test_random_input_causes_no_fault(ctx, tmp_path, monkeypatch):
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(tmp_path / "log"))
    log_lines: list[str] = []
    with gui_of(ctx, sequence_files(tmp_path), defocus=QUICK) as gui:
        play(gui, 25, 16, log_lines.append)
    assert log_lines and not (tmp_path / "log").exists()
