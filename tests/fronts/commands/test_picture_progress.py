"""Progress is for people: a terminal gets it, a log file does not."""

import io
import re

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.output import picture_progress as progress
from heatlens.render.frame_renderer import FrameRenderer, drained
from heatlens.render.gpu.textures import download
from support.plates import plate_of, room


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def drawn(renderer: FrameRenderer, stream: io.StringIO) -> np.ndarray:
    renderer.load(plate_of(*room()))
    shot = Shot(Lens(50.0, 1.4, 1.0, 36.0))
    with progress.picture_progress(renderer, shot, stream) as tell:
        return download(drained(renderer.steps(shot), tell))


def test_a_terminal_is_told_and_left_clean(
    ctx, renderer: FrameRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "_SILENT_S", -1.0)
    monkeypatch.setattr(progress, "_PAUSE_S", 0.0)
    terminal = Terminal()
    picture = drawn(renderer, terminal)
    assert "the layers, 0" in terminal.getvalue()
    assert re.search(r"heatlens: layer 1 of \d, about \d+ s left", terminal.getvalue())
    assert terminal.getvalue().endswith("\r\x1b[K")
    assert np.array_equal(picture, drawn(renderer, io.StringIO()))


def test_quick_pictures_and_log_files_are_not_disturbed(ctx, renderer: FrameRenderer) -> None:
    log = io.StringIO()
    drawn(renderer, log)
    assert log.getvalue() == ""
    terminal = Terminal()
    drawn(renderer, terminal)
    assert "layer" not in terminal.getvalue()


@pytest.mark.parametrize("rounds", [1, 2])
def test_the_share_that_is_done_grows_from_pass_to_pass_and_ends_below_all(rounds: int) -> None:
    count = progress.LayerCount(rounds)
    assert count.share("coc") is None
    shares = []
    for _ in range(rounds):
        for done in range(4):
            count.begin_layer(done, 4)
            shares += [count.share(name) for name in ("layer split", "hidden fill", "blur")]
    assert shares == sorted(shares) and len(set(shares)) == len(shares)
    assert 0 < shares[0] < 1 / rounds and 1 - 1 / rounds < shares[-1] < 1


def test_the_drawing_of_a_scene_counts_for_itself() -> None:
    """The time left of the layers does not count what went before them."""
    count = progress.PictureCount(drawings=10)
    for step in range(1, 6):
        count.take("pinhole", 2.0 * step)
    assert count.text("pinhole", 10.0) == "drawing the scene, about 10 s left"
    for step in range(6, 11):
        count.take("pinhole", 2.0 * step)
    assert count.text("fragments", 21.0) == "finding the layers, 21 s so far"
    for done in range(3):
        count.layers.begin_layer(done, 4)
    assert count.text("layer split", 22.0) == "layer 3 of 4, about 1 s left"
