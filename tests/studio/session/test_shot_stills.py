"""Stills of the shots of a reel: made once on a thread, and kept by the content of the file."""

import time

import numpy as np
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.studio.session.files import shot_stills
from heatlens.studio.session.files.shot_stills import ShotStills
from support.exr_files import write_file
from support.patience import PATIENCE_S
from support.session_files import write_scene

WIDTH, HEIGHT = 512, 256


def write_plate(folder, light: float = 0.25) -> str:
    """Write a plate whose left half is grey and whose right half is black; return its pattern."""
    grey = np.zeros((HEIGHT, WIDTH), np.float16)
    grey[:, : WIDTH // 2] = light
    write_file(folder / "a.0007.exr", {"R": grey, "G": grey, "B": grey})
    return str(folder / "a.####.exr")


def wait_for_still(stills, source: str, number: int = 0, frame: int | None = None):
    """Request the still of shot `number`, wait for it and return it."""
    stills.still(number, lambda: (source, PlateOptions(), frame))
    end = time.monotonic() + PATIENCE_S
    while not stills._futures[number].done():
        assert time.monotonic() < end
        time.sleep(0.002)
    return stills.still(number, lambda: pytest.fail("asked again"))


def sides(picture) -> tuple[float, float]:
    """Return the light of the left half and of the right edge."""
    light = picture[..., 1].astype(float)
    return light[:, : picture.shape[1] // 2].mean(), light[:, -1].max()


def test_shot_still_is_the_plate_at_128_by_64_pixels(tmp_path):
    """The plate needs no depth for its still."""
    picture = wait_for_still(ShotStills(lambda: None, None), write_plate(tmp_path))
    assert picture.shape == (64, 128, 4) and picture.dtype == np.float16
    assert sides(picture) == (0.25, 0.0)


def test_kept_still_is_read_again_only_when_the_file_changes(tmp_path, monkeypatch):
    source, folder = write_plate(tmp_path), tmp_path / "frames"
    before = wait_for_still(ShotStills(lambda: None, folder), source)
    with monkeypatch.context() as patched:
        patched.setattr(shot_stills, "read_light", lambda *_: pytest.fail("read again"))
        np.testing.assert_array_equal(
            wait_for_still(ShotStills(lambda: None, folder), source), before
        )
    write_plate(tmp_path, light=1.0)
    assert sides(wait_for_still(ShotStills(lambda: None, folder), source)) == (1.0, 0.0)


@pytest.mark.parametrize(
    "source",
    ["", "demo", "tev://", "{folder}/none.####.exr", "{folder}/bad.exr", "{folder}/two.glb"],
)
def test_shot_still_of_source_without_a_picture_is_none(tmp_path, source):
    (tmp_path / "bad.exr").write_bytes(b"no")
    write_scene(tmp_path / "two.glb")
    assert (
        wait_for_still(ShotStills(lambda: None, tmp_path), source.format(folder=tmp_path)) is None
    )


def test_clear_drops_the_stills_of_the_last_reel(tmp_path):
    stills = ShotStills(lambda: None, None)
    assert wait_for_still(stills, write_plate(tmp_path)) is not None
    stills.clear()
    assert wait_for_still(stills, "") is None
