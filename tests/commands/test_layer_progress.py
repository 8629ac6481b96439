"""Progress is for people: a terminal gets it, a log file does not."""

import io

import numpy as np
import pytest

from heatlens.commands import layer_progress as progress
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer
from support.plates import plate_of, room


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def drawn(renderer: FrameRenderer, stream: io.StringIO) -> np.ndarray:
    renderer.load(plate_of(*room()))
    with progress.layer_progress(renderer, stream):
        return renderer.pixels(Shot(Lens(50.0, 1.4, 1.0, 36.0)))


def test_a_terminal_is_told_and_left_clean(
    ctx, renderer: FrameRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "_SILENT_S", -1.0)
    terminal = Terminal()
    picture = drawn(renderer, terminal)
    assert "heatlens: layer 1 of " in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")
    assert np.array_equal(picture, drawn(renderer, io.StringIO()))


def test_quick_pictures_and_log_files_are_not_disturbed(ctx, renderer: FrameRenderer) -> None:
    log = io.StringIO()
    drawn(renderer, log)
    assert log.getvalue() == ""
    terminal = Terminal()
    drawn(renderer, terminal)
    assert "layer" not in terminal.getvalue()
