"""A sequence is read by one depth convention, wherever it is read and whichever frame is first."""

from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import PointMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view_geometry import PictureShape
from heatlens.media.plate.read import read_plate
from heatlens.render.source.opener import SourceOpener
from heatlens.render.source.plate_source import PlateSource, sequence_of_one_size
from heatlens.studio.session.marks.mark_commands import MarkCommands
from support.exr_files import rgb, write_file
from support.shared import shared_of

FRAMES = range(1, 6)
SIZE = 54, 96
MARK = PointMark("A", 25.0, 25.0)


class PlateHolder:
    """Stand-in for a renderer that keeps the loaded plate."""

    def load(self, plate):
        self.plate = plate


def write_sequence(folder, depth_of):
    for frame in FRAMES:
        depth = depth_of(frame).astype(np.float32)
        write_file(folder / f"s.{frame:04d}.exr", rgb(*SIZE) | {"Z": depth})
    return folder / "s.####.exr"


@pytest.fixture
def inverse(tmp_path, rng):
    """Write frames with 1/z as depth; from frame 3 on some surfaces are nearer than 1 m."""

    def depth_of(frame):
        z = 1 / rng.uniform(1.5 if frame < 3 else 0.6, 9.0, SIZE)
        z[:10], z[20:30, 20:30] = 0.0, 1 / 2.0
        return z

    return write_sequence(tmp_path, depth_of)


@pytest.fixture
def nearby(tmp_path, rng):
    """Write frames with distances as depth; only in the first frame this is unambiguous."""

    def depth_of(frame):
        z = rng.uniform(0.4, 3.0 if frame == 1 else 0.9, SIZE)
        z[20:30, 20:30] = 0.5
        return z

    return write_sequence(tmp_path, depth_of)


def open_source(name, frame=None):
    opener = SourceOpener(lambda: None)
    opener.open(str(name), PlateOptions(), frame)
    opener._current.wait()
    return opener.poll()


def guesses(pattern):
    return {read_plate(path).depth.convention for path in sorted(pattern.parent.glob("s.*.exr"))}


@pytest.mark.parametrize("first", [1, 4])
def test_window_and_export_read_each_frame_by_one_depth_convention(inverse, first):
    assert len(guesses(inverse)) > 1  # alone, the frames would be read differently
    window = open_source(inverse, first)
    source = PlateSource(window.text, sequence_of_one_size(window.text), window.options)
    shot, export = Shot(Lens(50.0, 2.8, 2.0, 36.0)), PlateHolder()
    origins = tuple(source.origin(shot, frame, "stop") for frame in FRAMES)
    loader = source.loader(shot, origins, export)
    assert window.frame == first
    decided = read_plate(inverse.parent / f"s.{FRAMES[0]:04d}.exr").depth
    for origin in origins:
        loader.load(origin)
        shown = window.cache.read_and_wait(origin.frame, window=0)
        assert shown.depth.convention == export.plate.depth.convention
        assert shown.depth.convention == window.settled_options.depth_convention
        assert (shown.depth.why, shown.depth.question) == (decided.why, decided.question)
        np.testing.assert_array_equal(shown.depth_m, export.plate.depth_m)
    loader.close()
    window.close()


def test_follow_reads_all_frames_by_the_depth_convention_shown(nearby):
    """Frames that are not in memory are followed too; read alone they would be refused."""
    with pytest.raises(InputError, match="which may be"):
        guesses(nearby)
    opened_plates, messages, edited_shots = open_source(nearby), [], []
    shot = Shot(Lens(50.0, 2.8, 2.0, 36.0), marks=(MARK,))
    editing = SimpleNamespace(shot=shot, do=edited_shots.append)
    source = SimpleNamespace(opened=opened_plates, picture_shape=lambda _: PictureShape(48, 32))
    marks = MarkCommands(
        shared=shared_of(editing, messages.append, source),
        timeline=SimpleNamespace(played=FrameRange(1, 5), cache=opened_plates.cache),
        scenes=SimpleNamespace(measure_point=lambda mark, frames: None),
    )
    marks.follow(MARK)
    marks._reader.wait()
    marks.poll()
    assert [str(sentence) for sentence in messages] == [
        "Reading 4 frames to follow A ...",
        "The focus follows A from 1 on.",
    ]
    assert {key.value for key in edited_shots[0].curves.focus_distance_m.keys} == {0.5}
    shown = [opened_plates.cache.read_and_wait(frame, window=0).depth_m[25, 25] for frame in FRAMES]
    assert shown == [0.5] * len(FRAMES)
    opened_plates.close()
