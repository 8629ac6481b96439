"""Test the pixels of written movies at many widths, and that equal frames give equal bytes."""

from pathlib import Path

import av
import numpy as np
import pytest
from av.video.reformatter import ColorRange, Colorspace

from heatlens.core.model.lens.lens import Lens
from heatlens.deliver.export.frame_files import RenderedFrame
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.movie import movie_file
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import PlannedFrame, fingerprint_of_movie
from heatlens.media.files.json_record import digest
from heatlens.render.source.source import Origin
from support.exports import shot_of
from support.plates import plate_of

HEIGHT, COUNT = 64, 8
FRAMES = tuple(range(1001, 1001 + COUNT))
LENS = Lens(50.0, 2.0, 2.0, 36.0)
WIDTHS = (1998, 2000, 1828, 1924, 1928, 1936, 1004, 850, 200, 1920)
FLAT = plate_of(np.zeros((1, 1, 4), np.float32), np.ones((1, 1), np.float32))


def write_test_movie(path: Path, pictures: list[np.ndarray]) -> bytes:
    """Write a movie of display pictures to `path`. Return the bytes of the file."""
    job = ExportJob(shot_of("plate.####.exr", FRAMES), FRAMES, parse_output(path))
    with movie_file(job, path, "mark") as movie:
        for frame, pixels in zip(FRAMES, pictures, strict=True):
            planned = PlannedFrame(frame, Origin(frame), LENS, path, "mark")
            movie.write(RenderedFrame(planned, FLAT, pixels))
    return path.read_bytes()


def ramps(width: int) -> list[np.ndarray]:
    """Return pictures of smooth ramps between different random colors at left and right."""
    across = np.linspace(0, 1, width, dtype=np.float32)[None, :, None]
    colors = np.random.default_rng(width).random((COUNT, 2, 3), dtype=np.float32)
    level = np.ones((HEIGHT, 1, 1), np.float32)
    return [level * (left * (1 - across) + right * across) for left, right in colors]


def decode_frames(path: Path) -> np.ndarray:
    """Return decoded frames (frames, H, W, 3) in 0..1, converted by one thread as in the writer."""
    with av.open(str(path)) as container:
        frames = [
            frame.reformat(
                format="rgb48le",
                src_colorspace=Colorspace.ITU709,
                src_color_range=ColorRange.MPEG,
                threads=1,
            ).to_ndarray()
            for frame in container.decode(video=0)
        ]
    return np.stack(frames).astype(np.float64) / 65280


@pytest.mark.parametrize(("suffix", "black", "white"), [(".mov", 64, 940), (".mp4", 16, 235)])
@pytest.mark.parametrize("level", [0.0, 0.25, 0.5, 1.0])
def test_gray_luma_codes_match_bt_709(tmp_path, suffix, black, white, level):
    """ITU-R BT.709: luma runs from 64 to 940 in 10 bits, and from 16 to 235 in 8."""
    path = tmp_path / f"grey{suffix}"
    write_test_movie(path, [np.full((HEIGHT, 96, 3), level, np.float32)] * COUNT)
    with av.open(str(path)) as container:
        plane = next(container.decode(video=0)).planes[0]
    kind = np.uint16 if white > 255 else np.uint8
    luma = np.frombuffer(plane, kind).reshape(plane.height, -1)[:, : plane.width]
    expected = black + level * (white - black)
    assert np.abs(luma.astype(float) - expected).max() <= 0.75


@pytest.mark.parametrize(("suffix", "most"), [(".mov", 0.02), (".mp4", 0.05)])
def test_movie_holds_its_frames_at_every_width_reproducibly(tmp_path, suffix, most):
    worst = {}
    for width in WIDTHS:
        path, pictures = tmp_path / f"{width}{suffix}", ramps(width)
        assert write_test_movie(path, pictures) == write_test_movie(
            tmp_path / f"again{suffix}", pictures
        ), width
        worst[width] = np.abs(decode_frames(path) - np.stack(pictures)).max()
    assert max(worst.values()) < most, worst


def test_fingerprint_of_movie_differs_from_first_encoding():
    """The first encoding had wrong pixels at most widths; its fingerprint was frames and rate."""
    first = digest({"frames": ["a", "b"], "frames_per_second": 24.0})
    assert fingerprint_of_movie(["a", "b"], 24.0) != first
