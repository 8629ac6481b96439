"""Test `heatlens shot size`, which keeps the size of a marked object with another lens."""

from dataclasses import replace

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.session_files import write_scene

LENS = Lens(35.0, 2.0, 3.0, 36.0)


@pytest.fixture
def wide_shot_path(tmp_path):
    write_scene(tmp_path / "a.glb")
    shot = Shot(LENS, source=str(tmp_path / "a.glb"), marks=(DistanceMark("A", 3.0),))
    write_shot(tmp_path / "wide.heatlens.json", shot)
    return tmp_path / "wide.heatlens.json"


def run_shot_size(shot, *more: str) -> int:
    return main(["shot", "size", str(shot), "A", "-o", str(shot.parent / "o.heatlens.json"), *more])


def test_shot_size_moves_camera_back_for_longer_lens(wide_shot_path, capsys):
    assert run_shot_size(wide_shot_path, "--focal-length", "70") == 0
    sized_shot = read_shot(wide_shot_path.parent / "o.heatlens.json")
    assert sized_shot.marks[0].distance_m == pytest.approx(6.0)
    assert sized_shot.lens.focus_distance_m == pytest.approx(6.0)
    assert "A is at 6 m with 70 mm at frame 1; it was at 3 m with 35 mm" in (
        capsys.readouterr().err
    )


def test_shot_size_by_camera_makes_dolly_zoom(wide_shot_path):
    shot = replace(read_shot(wide_shot_path), frames=FrameRange(1, 12))
    shot = shot.with_key(1, LensParameter.FOCAL_LENGTH, 35.0)
    write_shot(wide_shot_path, shot.with_key(12, LensParameter.FOCAL_LENGTH, 50.0))
    assert run_shot_size(wide_shot_path, "--by", "camera") == 0
    assert read_shot(wide_shot_path.parent / "o.heatlens.json").framing.track.is_moving
    assert (
        run_shot_size(wide_shot_path, "--by", "length") == 0
    )  # a camera that stands has one length
    sized_shot = read_shot(wide_shot_path.parent / "o.heatlens.json")
    assert sized_shot.lens_at(12).focal_length_mm == pytest.approx(35.0)


def test_shot_size_measures_point_mark(wide_shot_path):
    shot = replace(read_shot(wide_shot_path), marks=(PointMark("A", 640.0, 360.0),))
    write_shot(wide_shot_path, shot)
    assert run_shot_size(wide_shot_path, "--focal-length", "50") == 0
    sized_shot = read_shot(wide_shot_path.parent / "o.heatlens.json")
    assert (sized_shot.marks[0].x_px, sized_shot.marks[0].y_px) == pytest.approx((640.0, 360.0))


NO_DOLLY = (
    "A plate is seen from one place, so no camera can move to keep a size: 70 mm shows the middle "
    "50 % of its width and height, everything 2 times as large."
)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"source": "a.exr"}, NO_DOLLY), ({"marks": ()}, "has no mark 'A'; its marks: none.")],
)
def test_shot_size_rejects_plate_and_unknown_mark(wide_shot_path, capsys, change, words):
    write_shot(wide_shot_path, replace(read_shot(wide_shot_path), **change))
    assert run_shot_size(wide_shot_path, "--focal-length", "70") == 2
    assert words in " ".join(capsys.readouterr().err.split())
