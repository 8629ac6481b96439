"""Test the progress of a rendered picture, which a terminal shows and a log file does not."""

import io
import re

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.output import picture_progress as progress
from heatlens.render.frame_renderer import FrameRenderer, run_all_steps
from heatlens.render.gpu.textures import download
from support.plates import plate_of, room


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def render_with_progress(renderer: FrameRenderer, stream: io.StringIO) -> np.ndarray:
    renderer.load(plate_of(*room()))
    shot = Shot(Lens(50.0, 1.4, 1.0, 36.0))
    with progress.picture_progress(renderer, shot, stream) as report_progress:
        return download(run_all_steps(renderer.steps(shot), report_progress))


def test_progress_on_terminal_is_shown_and_cleared(
    ctx, renderer: FrameRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "_SILENT_START_S", -1.0)
    monkeypatch.setattr(progress, "_UPDATE_INTERVAL_S", 0.0)
    terminal = Terminal()
    picture = render_with_progress(renderer, terminal)
    assert "the layers, 0" in terminal.getvalue()
    assert re.search(r"heatlens: layer 1 of \d, about \d+ s left", terminal.getvalue())
    assert terminal.getvalue().endswith("\r\x1b[K")
    assert np.array_equal(picture, render_with_progress(renderer, io.StringIO()))


def test_progress_is_not_shown_for_quick_pictures_and_log_files(
    ctx, renderer: FrameRenderer
) -> None:
    log = io.StringIO()
    render_with_progress(renderer, log)
    assert log.getvalue() == ""
    terminal = Terminal()
    render_with_progress(renderer, terminal)
    assert "layer" not in terminal.getvalue()


@pytest.mark.parametrize("rounds", [1, 2])
def test_layer_count_share_grows_from_pass_to_pass_below_1(rounds: int) -> None:
    count = progress.LayerCount(rounds)
    assert count.finished_share("coc") is None
    shares = []
    for _ in range(rounds):
        for layer_index in range(4):
            count.begin_layer(layer_index, 4)
            shares += [
                count.finished_share(name) for name in ("layer split", "hidden fill", "blur")
            ]
    assert shares == sorted(shares) and len(set(shares)) == len(shares)
    assert 0 < shares[0] < 1 / rounds and 1 - 1 / rounds < shares[-1] < 1


def test_picture_count_estimates_scene_drawing_separately() -> None:
    """The estimated time of the layers excludes the drawing of the scene before them."""
    count = progress.PictureCount(drawings=10)
    for step in range(1, 6):
        count.count_step("pinhole", 2.0 * step)
    assert count.text("pinhole", 10.0) == "drawing the scene, about 10 s left"
    for step in range(6, 11):
        count.count_step("pinhole", 2.0 * step)
    assert count.text("fragments", 21.0) == "finding the layers, 21 s so far"
    for layer_index in range(3):
        count.layers.begin_layer(layer_index, 4)
    assert count.text("layer split", 22.0) == "layer 3 of 4, about 1 s left"
