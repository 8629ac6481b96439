"""Depth that lies in files of its own, beside the pictures, in the window."""

import numpy as np

from heatlens.core.model.shot.plate_options import PlateOptions
from support.gui import gui_of
from support.plates import room
from support.session_files import HEIGHT, QUICK, WIDTH, write_plate


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
