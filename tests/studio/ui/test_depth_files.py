"""Depth that lies in files of its own, beside the pictures, in the window."""

from collections.abc import Iterator

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from heatlens.core.model.depth_words import DepthSide
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.sequence.folder_walk import ChosenFile
from heatlens.studio.settings.file_purposes import PURPOSES
from support.gui import Gui, gui_of
from support.plates import room
from support.session_files import HEIGHT, QUICK, WIDTH, room_file, write_plate


def test_rewritten_depth_file_is_shown_and_its_frame_rendered_again(ctx, tmp_path):
    color, depth = room(WIDTH, HEIGHT)
    for frame in (1, 2):
        write_plate(tmp_path / f"rgb.{frame:04}.exr", color)
        write_plate(tmp_path / f"depth.{frame:04}.exr", color[..., :0], Z=depth)
    options = PlateOptions(
        depth_source=str(tmp_path / "depth.####.exr"), depth_convention="distance"
    )
    pictures = tmp_path / "rgb.####.exr"
    with gui_of(ctx, pictures, plate_options=options, defocus=QUICK) as gui:
        source, jobs = gui.session.source, gui.session.time.frames_ahead.jobs
        gui.until(
            lambda: len(gui.session.time.frames_ahead.progress.rendered_frames) == 2,
            "both frames rendered",
            120.0,
        )
        before, keys = source.plate.depth_m, [jobs.job_of(frame).key for frame in (1, 2)]
        write_plate(tmp_path / "depth.0001.exr", color[..., :0], Z=2 * depth)
        gui.until(lambda: source.plate.depth_m is not before, "the depth as it is now", 60.0)
        np.testing.assert_allclose(source.plate.depth_m, 2 * before)
        gui.until(lambda: key_of(jobs, 1) not in (None, keys[0]), "another key", 60.0)
        assert key_of(jobs, 2) == keys[1]


def key_of(jobs, frame):
    job = jobs.job_of(frame)
    return None if job is None else job.key


@pytest.fixture
def asked(ctx, tmp_path) -> Iterator[Gui]:
    """Return a window that has a plate, and was given a picture without depth to open."""
    picture = tmp_path / "photo.png"
    gray = np.linspace(0, 255, WIDTH, dtype=np.uint8)
    Image.fromarray(np.tile(gray, (HEIGHT, 1))).convert("RGB").save(picture)
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as gui:
        gui.session.files.commands.open(str(picture))
        gui.until(lambda: "no depth Cancel" in gui.drawn, "the question")
        gui.frame(3)
        yield gui


def test_half_of_a_picture_without_depth_is_taken_as_its_depth(asked):
    asked.click(asked.middle("no depth Right half"))
    source = asked.session.source
    asked.until(lambda: source.plate.path.name == "photo.png", "the picture")
    assert source.plate.display_window.width == WIDTH // 2
    assert asked.session.facts.shot.plate_options.depth_side is DepthSide.RIGHT


def test_picture_opened_without_depth_is_all_at_one_distance(asked):
    assert not asked.session.messages.text  # the box alone says what is missing
    asked.click(asked.middle("no depth Open without"))
    source = asked.session.source
    asked.until(lambda: source.plate.path.name == "photo.png", "the picture")
    assert set(source.plate.depth_m.flat) == {asked.session.facts.shot.plate_options.one_distance_m}
    asked.settled()


def test_file_of_the_depth_is_chosen_in_a_dialog_after_enter(asked, tmp_path):
    asked.key(imgui.Key.enter)
    asked.frame(3)
    assert asked.ui.dialogs.is_open and not asked.session.files.commands.no_depth.name
    asked.key(imgui.Key.escape)
    _, depth = room(WIDTH, HEIGHT)
    write_plate(tmp_path / "z.exr", np.zeros((HEIGHT, WIDTH, 0), np.float32), Z=depth)
    choice = ChosenFile(PURPOSES["depth"], tmp_path / "z.exr")
    asked.session.files.commands.apply_choice(choice)
    source = asked.session.source
    asked.until(lambda: source.plate.path.name == "photo.png", "the picture")
    np.testing.assert_allclose(source.plate.depth_m, depth)


def test_escape_leaves_the_open_plate_and_asks_no_more(asked):
    asked.key(imgui.Key.escape)
    asked.drawn.clear()
    asked.frame(4)
    assert "no depth Cancel" not in asked.drawn
    assert asked.session.source.plate.path.name == "room.exr"


def test_all_answers_stand_in_one_line(asked):
    tops = {rect[1] for name, rect in asked.drawn.items() if name.startswith("no depth ")}
    assert len(tops) == 1
