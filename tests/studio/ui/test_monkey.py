"""A monkey finds its way through the window; `tests/fuzz/monkey.py` lets it play for longer."""

from fuzz.monkey import play
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import QUICK


def test_a_monkey_meets_no_fault(ctx, tmp_path, monkeypatch):
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(tmp_path / "log"))
    told: list[str] = []
    with gui_of(ctx, sequence_files(tmp_path), defocus=QUICK) as gui:
        play(gui, 25, 16, told.append)
    assert told and not (tmp_path / "log").exists()
