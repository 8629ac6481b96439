"""Test the opening of a lens in camera files: written, read back and set on a shot."""

from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.camera.blender_write import blender_text
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.media.camera.into_shot import with_camera
from heatlens.media.camera.nuke_write import nuke_text
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.opening_picture import read_opening_image
from heatlens.render.source.named import camera_of_shot
from support.opening_images import heart_path

LENS = Lens(
    50.0,
    2.0,
    2.0,
    36.0,
    blades=6,
    blade_rotation_deg=15.0,
    blade_curvature=0.25,
    cat_eye=0.5,
    rim=-0.5,
    axial_colour_mm=0.25,
    widest_f_stop=1.0,
)
SHOT = Shot(LENS, frames=FrameRange(1, 2))


@pytest.mark.parametrize("suffix", [".json", ".csv", ".usda"])
def test_camera_file_keeps_all_of_the_opening(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"cam{suffix}"
    write_camera(path, camera_of_shot(SHOT, "cam"))
    bare = Shot(Lens(35.0, 4.0, 9.0, 24.0), frames=SHOT.frames)
    assert with_camera(bare, read_camera(str(path))).lens == LENS


def test_round_opening_is_written_without_bokeh_node() -> None:
    camera = camera_of_shot(Shot(Lens(50.0, 2.0, 2.0, 36.0), frames=SHOT.frames), "cam")
    assert camera.opening["blades"] == (0.0, 0.0) and not camera.shaped_fields
    node = nuke_text(camera)
    assert "blades 0.0" in node and "Bokeh" not in node


@pytest.mark.parametrize("suffix", [".json", ".csv", ".usda"])
def test_shot_new_takes_opening_of_camera_and_options_override_it(
    tmp_path: Path, suffix: str
) -> None:
    camera, shot = tmp_path / f"cam{suffix}", tmp_path / "s.heatlens.json"
    write_camera(camera, camera_of_shot(SHOT, "cam"))
    words = ["shot", "new", "no.####.exr", "--camera", str(camera), "-o", str(shot)]
    assert main([*words, "--rim", "0.75"]) == 0
    assert read_shot(shot).lens == replace(LENS, rim=0.75)


@pytest.mark.parametrize("suffix", [".json", ".csv", ".usda"])
def test_camera_file_stores_opening_image_relative_to_itself(tmp_path: Path, suffix: str) -> None:
    (tmp_path / "heart.png").write_bytes(heart_path().read_bytes())
    lens = replace(LENS, aperture_image=read_opening_image(tmp_path / "heart.png"))
    path = tmp_path / f"cam{suffix}"
    camera = camera_of_shot(replace(SHOT, lens=lens), "cam")
    assert any("heart.png" in note for note in camera.notes)
    write_camera(path, camera)
    assert str(tmp_path) not in path.read_text() and "heart.png" in path.read_text()
    bare = Shot(Lens(35.0, 4.0, 9.0, 24.0), frames=SHOT.frames)
    assert with_camera(bare, read_camera(str(path))).lens == lens
    (tmp_path / "heart.png").unlink()
    with pytest.raises(InputError, match=r"cam.*heart.png is not there"):
        read_camera(str(path))


def test_scripts_quote_path_of_opening_image() -> None:
    lens = replace(LENS, aperture_image=OpeningImage('/a "b"/[$h].png'))
    camera = camera_of_shot(replace(SHOT, lens=lens), "cam")
    assert repr('/a "b"/[$h].png') in blender_text(camera)
    assert r'aperture_image "/a \"b\"/\[\$h\].png"' in nuke_text(camera)


def test_blender_and_nuke_scripts_have_the_opening() -> None:
    camera = camera_of_shot(SHOT, "cam")
    script = blender_text(camera)
    assert "'dof.aperture_blades': 6" in script
    # A corner at 90 + 15 degrees; Blender's first is half a blade, 30 degrees, from its rotation.
    assert "'dof.aperture_rotation': 0.2617" in script
    assert "'[\"cat_eye\"]': 0.5" in script
    node = nuke_text(camera)
    assert "blades 6.0" in node and "rim -0.5" in node


def test_usd_camera_has_custom_data_of_physical_cameras_draft(tmp_path: Path) -> None:
    from pxr import Usd

    path = tmp_path / "cam.usda"
    lens = Lens(50.0, 2.0, 2.0, 36.0, blades=6, squeeze=2.0)
    write_camera(path, camera_of_shot(Shot(lens, frames=SHOT.frames), "cam"))
    stage = Usd.Stage.Open(str(path))
    custom_data = stage.GetDefaultPrim().GetCustomDataByKey
    assert custom_data("PhysicalCameraLens") == {"shutter_blades": 6}
    assert custom_data("PhysicalCameraLensModelPinhole") == {"squeeze": 2.0}
    plain = Shot(Lens(50.0, 2.0, 2.0, 36.0), frames=SHOT.frames)
    write_camera(tmp_path / "plain.usda", camera_of_shot(plain, "cam"))
    stage = Usd.Stage.Open(str(tmp_path / "plain.usda"))
    assert not stage.GetDefaultPrim().HasAuthoredCustomData()


def test_camera_of_breathing_lens_has_focal_length_and_f_stop_per_frame() -> None:
    lens = Lens(50.0, 2.0, 2.0, 36.0, breathing=0.8, close_focus_m=1.0)
    shot = Shot(lens, frames=FrameRange(1, 3))
    for frame, distance_m in ((1, 1.0), (3, 4.0)):
        shot = shot.with_key(frame, LensParameter.FOCUS_DISTANCE, distance_m)
    camera = camera_of_shot(shot, "cam")
    for index, frame in enumerate(camera.frames):
        view = 1.0 - 0.2 / shot.lens_at(frame).focus_distance_m
        assert camera.focal_length_mm[index] == pytest.approx(50.0 / view)
        assert camera.f_stop[index] == pytest.approx(2.0 / view)  # the opening stays as wide
    node = nuke_text(camera)
    assert node.count("focal {{curve x1 ") == 1 and "62.5" in node
