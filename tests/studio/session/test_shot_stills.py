"""Stills of the shots of a reel: made once, kept by the content of the file, never in the way."""

import time

import numpy as np
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.studio.session.files import shot_stills
from heatlens.studio.session.files.shot_stills import ShotStills
from support.exr_files import write_file
from support.session_files import write_scene

WIDTH, HEIGHT = 512, 256


def plate(folder, light: float = 0.25) -> str:
    """Write a plate whose left half is grey and whose right half is black; return its pattern."""
    grey = np.zeros((HEIGHT, WIDTH), np.float16)
    grey[:, : WIDTH // 2] = light
    write_file(folder / "a.0007.exr", {"R": grey, "G": grey, "B": grey})
    return str(folder / "a.####.exr")


def still(stills, source: str, number: int = 0, frame: int | None = None):
    """Wait for a still."""
    stills.of(number, lambda: (source, PlateOptions(), frame))
    end = time.monotonic() + 60.0
    while not stills._coming[number].done():
        assert time.monotonic() < end
        time.sleep(0.002)
    return stills.of(number, lambda: pytest.fail("asked again"))


def sides(picture) -> tuple[float, float]:
    """Return the light of the left half and of the right edge."""
    light = picture[..., 1].astype(float)
    return light[:, : picture.shape[1] // 2].mean(), light[:, -1].max()


def test_a_still_is_the_light_of_the_plate_made_smaller(tmp_path):
    """A plate needs no depth for that."""
    picture = still(ShotStills(lambda: None, None), plate(tmp_path))
    assert picture.shape == (64, 128, 4) and picture.dtype == np.float16
    assert sides(picture) == (0.25, 0.0)


def test_a_kept_still_is_not_read_again_until_the_file_changes(tmp_path, monkeypatch):
    source, folder = plate(tmp_path), tmp_path / "frames"
    before = still(ShotStills(lambda: None, folder), source)
    with monkeypatch.context() as patched:
        patched.setattr(shot_stills, "read_light", lambda *_: pytest.fail("read again"))
        np.testing.assert_array_equal(still(ShotStills(lambda: None, folder), source), before)
    plate(tmp_path, light=1.0)
    assert sides(still(ShotStills(lambda: None, folder), source)) == (1.0, 0.0)


@pytest.mark.parametrize(
    "source",
    ["", "demo", "tev://", "{folder}/none.####.exr", "{folder}/bad.exr", "{folder}/two.glb"],
)
def test_a_shot_without_a_picture_has_no_still(tmp_path, source):
    (tmp_path / "bad.exr").write_bytes(b"no")
    write_scene(tmp_path / "two.glb")
    assert still(ShotStills(lambda: None, tmp_path), source.format(folder=tmp_path)) is None


def test_another_reel_begins_anew(tmp_path):
    stills = ShotStills(lambda: None, None)
    assert still(stills, plate(tmp_path)) is not None
    stills.clear()
    assert still(stills, "") is None
