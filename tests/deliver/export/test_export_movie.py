"""Exported movies, decoded again: frames, rate, colours, and what players are told of them."""

import resource
import sys
import time
from dataclasses import replace
from fractions import Fraction

import av
import numpy as np
import pytest
from av.video.reformatter import ColorRange, Colorspace, Interpolation

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import exact_rate
from heatlens.deliver.export import movie as movies
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.header.camera_header import lens_attributes
from support.command_line import started
from support.exports import (
    FRAMES,
    WIDTH,
    exported,
    files_in,
    refused,
    shot_of,
    with_focus,
    write_plate,
    write_plates,
)
from support.exr_files import write_file
from support.written_pictures import pixels

PLAIN = ("--view", "sRGB curve")


def decoded(path) -> np.ndarray:
    """Return (frames, H, W, 3) in 0..255, decoded as Rec.709 video."""
    with av.open(str(path)) as container:
        frames = [
            frame.reformat(
                format="rgb48le",
                src_colorspace=Colorspace.ITU709,
                src_color_range=ColorRange.MPEG,
                interpolation=Interpolation.BICUBIC | Interpolation.ACCURATE_RND,
            ).to_ndarray()
            for frame in container.decode(video=0)
        ]
    return np.stack(frames).astype(float) / 256


def box(data: bytes, name: bytes) -> bytes:
    """Return what follows the name of a box of the file."""
    at = data.index(name)
    return data[at + 4 : at + 16]


@pytest.mark.parametrize(
    ("suffix", "codec", "pixel_format"),
    [(".mov", "prores", "yuv422p10le"), (".mp4", "h264", "yuv420p")],
)
def test_a_movie_has_every_frame_at_the_shots_rate(
    capsys, shot_file, tmp_path, suffix, codec, pixel_format
):
    path = tmp_path / f"m{suffix}"
    exported(capsys, shot_file, path, "--fps", "23.976")
    with av.open(str(path)) as container:
        (stream,) = container.streams
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == (codec, pixel_format)
        assert stream.frames == len(FRAMES)
        assert stream.average_rate == Fraction(24000, 1001)
        times = [frame.pts * stream.time_base for frame in container.decode(video=0)]
    assert times == [i * Fraction(1001, 24000) for i in range(len(FRAMES))]
    assert files_in(tmp_path).keys() == {"s.heatlens.json", path.name}


@pytest.mark.parametrize(("suffix", "kind"), [(".mov", b"nclc"), (".mp4", b"nclx")])
def test_players_are_told_rec_709(capsys, shot_file, tmp_path, suffix, kind):
    """Both in the container, which players read first, and in the stream."""
    path = tmp_path / f"m{suffix}"
    exported(capsys, shot_file, path)
    assert box(path.read_bytes(), b"colr")[:10] == kind + b"\0\1\0\1\0\1"
    with av.open(str(path)) as container:
        context = container.streams.video[0].codec_context
        assert context.color_primaries == context.color_trc == context.colorspace == 1
        assert context.color_range == 1


def test_each_frame_of_prores_says_what_the_container_says(capsys, shot_file, tmp_path):
    """Editing programs believe the header of the frames: primaries, curve and matrix in a row."""
    exported(capsys, shot_file, tmp_path / "m.mov")
    headers = (tmp_path / "m.mov").read_bytes().split(b"icpf")[1:]
    assert [header[14:17] for header in headers] == [b"\1\1\1"] * len(FRAMES)


def flat_plates(folder):
    """Frames of one colour each, and a slow ramp: chroma at half width loses nothing of them."""
    folder.mkdir()
    colors = [(0.18, 0.18, 0.18), (0.9, 0.05, 0.02), (0.02, 0.6, 0.1), (0.05, 0.1, 0.8)]
    ramp = np.linspace(0, 1, 64, dtype=np.float32)[None, :, None]
    camera = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
    for frame, color in zip(range(1001, 1006), [*colors, ramp], strict=True):
        picture = np.broadcast_to(np.asarray(color, np.float32), (32, 64, 3))
        named = {n: np.ascontiguousarray(picture[..., i]) for i, n in enumerate("RGB")}
        depth = np.full((32, 64), 2.24, np.float32)
        write_file(folder / f"plate.{frame}.exr", named | {"Z": depth}, **camera)
    return str(folder / "plate.####.exr")


@pytest.mark.parametrize(("suffix", "most", "mean"), [(".mov", 1.5, 0.75), (".mp4", 3.5, 1.5)])
def test_colours_are_those_of_the_png_export(capsys, tmp_path, suffix, most, mean):
    """In code values of 255; ProRes has 10 bits, H.264 here 8 of which video uses 220.

    Of saturated colours, as the plain curve leaves them.
    """
    source = flat_plates(tmp_path / "plates")
    words = ("--focus-distance", "2.24", "--bokeh", "heat", "--quality", "draft", *PLAIN)
    exported(capsys, source, tmp_path / f"m{suffix}", *words)
    exported(capsys, source, tmp_path / "n.####.png", *words)
    found = decoded(tmp_path / f"m{suffix}")
    expected = np.stack([pixels(tmp_path / f"n.{frame}.png") for frame in range(1001, 1006)])
    assert np.abs(found - expected).max() <= most
    assert np.abs((found - expected).mean(axis=(1, 2))).max() < mean


def test_prores_of_a_picture_is_the_picture(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "m.mov", "--exposure=-1")
    exported(capsys, shot_file, tmp_path / "n.####.png", "--exposure=-1")
    expected = np.stack([pixels(tmp_path / f"n.{frame}.png") for frame in FRAMES])
    luma = np.array([0.2126, 0.7152, 0.0722])
    difference = (decoded(tmp_path / "m.mov") - expected) @ luma
    assert np.abs(difference).mean() < 2.0
    for frame, picture in enumerate(decoded(tmp_path / "m.mov")):
        distances = [np.abs(picture - other).mean() for other in expected]
        assert np.argmin(distances) == frame


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
@pytest.mark.parametrize("size", [(33, 17), (3, 5), (1, 1)])
def test_odd_sizes_gain_a_row_or_a_column_like_the_last(capsys, tmp_path, suffix, size):
    (tmp_path / "plates").mkdir()
    for frame in (1001, 1002):
        write_plate(tmp_path / "plates" / f"plate.{frame}.exr", size=size)
    shot = shot_of(str(tmp_path / "plates" / "plate.####.exr"), (1001, 1002))
    write_shot(tmp_path / "s.heatlens.json", shot)
    exported(capsys, tmp_path / "s.heatlens.json", tmp_path / f"m{suffix}")
    found = decoded(tmp_path / f"m{suffix}")
    width, height = (side + side % 2 for side in size)
    assert found.shape == (2, height, width, 3)


@pytest.mark.parametrize(("words", "wider", "aspect"), [((), 1, 2), (("--desqueeze", "2"), 2, 1)])
def test_pixels_that_are_not_square_are_told_or_made_so(capsys, tmp_path, words, wider, aspect):
    source = write_plates(tmp_path / "plates", (1001, 1002), pixelAspectRatio=2.0)
    write_shot(tmp_path / "s.heatlens.json", shot_of(source, (1001, 1002)))
    exported(capsys, tmp_path / "s.heatlens.json", tmp_path / "m.mov", *words)
    with av.open(str(tmp_path / "m.mov")) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.sample_aspect_ratio) == (wider * WIDTH, aspect)


def test_burn_in_is_in_the_movie(capsys, shot_file, tmp_path):
    for name, words in (("a", ()), ("b", ("--burn-in",))):
        exported(capsys, shot_file, tmp_path / f"{name}.mov", *words)
    difference = np.abs(decoded(tmp_path / "a.mov") - decoded(tmp_path / "b.mov"))
    assert difference[:, -4:].max() > 20 > difference[:, :8].max()


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
def test_a_finished_movie_is_left_and_the_same_one_has_the_same_bytes(
    capsys, shot_file, tmp_path, suffix
):
    path = tmp_path / f"m{suffix}"
    exported(capsys, shot_file, path)
    first = path.read_bytes()
    assert "6 were finished before" in exported(capsys, shot_file, path)
    assert "6 frames written." in exported(capsys, shot_file, path, "--force")
    assert path.read_bytes() == first
    write_shot(shot_file, with_focus(read_shot(shot_file), 1004, 0.7))
    assert "6 frames written." in exported(capsys, shot_file, path)
    assert path.read_bytes() != first


def test_a_movie_that_fails_leaves_the_one_before(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "m.mov")
    before = files_in(tmp_path)
    (tmp_path / "plates" / "plate.1005.exr").write_bytes(b"no plate")
    assert "plate.1005.exr" in refused(capsys, shot_file, tmp_path / "m.mov")
    assert files_in(tmp_path) == before


def test_a_frame_of_another_size_is_no_frame_of_the_movie(capsys, shot_file, tmp_path):
    write_plate(tmp_path / "plates" / "plate.1003.exr", size=(20, 30))
    said = refused(capsys, shot_file, tmp_path / "m.mov")
    assert "plate.1003.exr" in said and "20x30" in said and "32x18" in said
    assert "m.mov" not in files_in(tmp_path)


def test_what_the_encoder_refuses_is_told_in_a_sentence(capsys, shot_file, tmp_path, monkeypatch):
    refusing = replace(movies._CODECS[".mp4"], options={"profile": "baseline", "crf": "0"})
    monkeypatch.setitem(movies._CODECS, ".mp4", refusing)
    said = refused(capsys, shot_file, tmp_path / "m.mp4")
    assert "m.mp4 could not" in said
    assert "m.mp4" not in files_in(tmp_path)


def test_a_disk_that_fills_up_leaves_no_movie(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "m.mov")
    size = (tmp_path / "m.mov").stat().st_size
    (tmp_path / "m.mov").unlink()
    before = files_in(tmp_path)
    words = ("export", shot_file, "-o", tmp_path / "m.mov")
    process = started(
        *words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size - 1, size - 1))
    )
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 2
    assert "m.mov could not" in said and "Traceback" not in said
    assert files_in(tmp_path) == before


def test_a_movie_whose_export_was_killed_is_made_again(capsys, shot_file, tmp_path):
    exported(capsys, shot_file, tmp_path / "m.mov")
    whole = files_in(tmp_path)
    (tmp_path / "m.mov").unlink()
    process = started("export", shot_file, "-o", tmp_path / "m.mov")
    while process.poll() is None and not list(tmp_path.glob(".heatlens-*.part")):
        time.sleep(0.001)
    process.kill()
    process.communicate(timeout=60)
    assert len(files_in(tmp_path)) == 2 and "m.mov" not in files_in(tmp_path)
    exported(capsys, shot_file, tmp_path / "m.mov")
    assert files_in(tmp_path) == whole


def test_a_display_of_other_primaries_is_refused(capsys, shot_file, tmp_path):
    said = refused(capsys, shot_file, tmp_path / "m.mov", "--display", "Display P3 - Display")
    assert "Rec.709" in said and "m.mov" not in files_in(tmp_path)


def test_without_pyav_a_movie_is_refused_and_frames_are_not(
    capsys, shot_file, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "av", None)
    assert "pip install 'heatlens[movie]'" in refused(capsys, shot_file, tmp_path / "m.mov")
    exported(capsys, shot_file, tmp_path / "n.####.png")


@pytest.mark.parametrize(
    ("told", "rate"),
    [
        (24.0, Fraction(24)),
        (25.0, Fraction(25)),
        (23.976, Fraction(24000, 1001)),
        (23.98, Fraction(24000, 1001)),
        (29.97, Fraction(30000, 1001)),
        (59.94, Fraction(60000, 1001)),
        (12.5, Fraction(25, 2)),
        (0.5, Fraction(1, 2)),
    ],
)
def test_rates_of_broadcast_are_exact(told, rate):
    assert exact_rate(told) == rate


def test_an_error_of_this_kind_is_ours():
    """`replacing` and the encoder's own words meet: one sentence, of a class that is caught."""
    with (
        pytest.raises(InputError, match=r"m\.mov could not be written: Generic error"),
        movies._failures_reported(movies.Path("m.mov"), av),
    ):
        raise av.error.ExternalError(542398533, "Generic error")
