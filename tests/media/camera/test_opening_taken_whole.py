"""Test that a camera file replaces the whole opening of a shot, default values included."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import options_of, type_of
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.media.camera.into_shot import with_camera
from heatlens.media.camera.samples import OPENING_TRACKS, PLAIN_OPENING, CameraSamples
from heatlens.media.camera.usd_read import usd_camera
from heatlens.media.documents.shot_file import read_shot
from heatlens.render.source.named import camera_of_shot
from support.opening_images import heart_path

READERS = {".json": read_camera, ".csv": read_camera, ".usda": usd_camera, ".usdc": usd_camera}
ROUND = Lens(50.0, 2.0, 2.0, 36.0)
BLADED = replace(ROUND, blades=5, cat_eye=0.5, squeeze=2.0, widest_f_stop=1.4, rim=-0.5)


def opening_values(name: str) -> st.SearchStrategy[float]:
    """Return a strategy for a field of the opening that often gives its default value."""
    if name == "widest_f_stop":
        return st.sampled_from((None, 1.0, 2.0))
    if type_of(Lens, name) is int:
        return st.sampled_from((0, 3, 7, 16))
    option = options_of(Lens)[name]
    values = st.floats(option.least, option.most, width=32)
    return st.one_of(st.just(PLAIN_OPENING[name]), values)


lenses = st.fixed_dictionaries({n: opening_values(n) for n in (*OPENING_TRACKS, "squeeze")}).map(
    lambda values: replace(ROUND, **values)
)


@pytest.mark.parametrize("suffix", READERS)
@given(mine=lenses, before=lenses)
def test_with_camera_replaces_any_opening_by_that_of_file(suffix, mine, before):
    frames = FrameRange(1, 2)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"cam{suffix}"
        write_camera(path, camera_of_shot(Shot(mine, frames=frames), "cam"))
        new_shot = with_camera(Shot(before, frames=frames), READERS[suffix](str(path)))
    for name in PLAIN_OPENING:
        assert getattr(new_shot.lens, name) == pytest.approx(getattr(mine, name)), name


@pytest.mark.parametrize("suffix", READERS)
def test_with_camera_removes_opening_image_if_file_has_none(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"cam{suffix}"
    write_camera(path, camera_of_shot(Shot(ROUND, frames=FrameRange(1, 2)), "cam"))
    heart = replace(ROUND, aperture_image=OpeningImage(str(heart_path())))
    assert with_camera(Shot(heart), READERS[suffix](str(path))).lens == ROUND


def test_with_camera_keeps_opening_if_camera_has_none() -> None:
    foreign = CameraSamples("cam", (1,), focal_length_mm=(35.0,))
    new_lens = with_camera(Shot(BLADED), foreign).lens
    assert new_lens == replace(BLADED, focal_length_mm=35.0)


def test_shot_new_option_overrides_opening_of_camera(tmp_path: Path) -> None:
    camera, shot = tmp_path / "cam.json", tmp_path / "s.heatlens.json"
    write_camera(camera, camera_of_shot(Shot(ROUND, frames=FrameRange(1, 2)), "cam"))
    words = ["shot", "new", "no.####.exr", "--camera", str(camera), "-o", str(shot)]
    assert main([*words, "--blades", "7"]) == 0
    assert read_shot(shot).lens == replace(ROUND, blades=7)
