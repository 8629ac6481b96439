"""Test exported movies by decoding them: frames, rate, colors, and metadata for players."""

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
from support.command_line import start_heatlens, start_heatlens_on_full_disk
from support.exports import (
    FRAMES,
    WIDTH,
    export_shot,
    files_in,
    refused_export_message,
    shot_of,
    with_focus,
    write_plate,
    write_plates,
)
from support.exr_files import write_file
from support.patience import PATIENCE_S
from support.written_pictures import pixels

PLAIN = ("--view", "sRGB curve")


def decode_frames(path) -> np.ndarray:
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


def box_content(data: bytes, name: bytes) -> bytes:
    """Return the 12 bytes that follow the name of a box in an MP4 or MOV file."""
    start = data.index(name)
    return data[start + 4 : start + 16]


@pytest.mark.parametrize(
    ("suffix", "codec", "pixel_format"),
    [(".mov", "prores", "yuv422p10le"), (".mp4", "h264", "yuv420p")],
)
def test_exported_movie_has_all_frames_at_requested_rate(
    capsys, shot_file, tmp_path, suffix, codec, pixel_format
):
    path = tmp_path / f"m{suffix}"
    export_shot(capsys, shot_file, path, "--fps", "23.976")
    with av.open(str(path)) as container:
        (stream,) = container.streams
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == (codec, pixel_format)
        assert stream.frames == len(FRAMES)
        assert stream.average_rate == Fraction(24000, 1001)
        times = [frame.pts * stream.time_base for frame in container.decode(video=0)]
    assert times == [i * Fraction(1001, 24000) for i in range(len(FRAMES))]
    assert files_in(tmp_path).keys() == {"s.heatlens.json", path.name}


@pytest.mark.parametrize(("suffix", "kind"), [(".mov", b"nclc"), (".mp4", b"nclx")])
def test_movie_container_and_stream_declare_rec_709(capsys, shot_file, tmp_path, suffix, kind):
    """Check the container, which players read first, and the stream."""
    path = tmp_path / f"m{suffix}"
    export_shot(capsys, shot_file, path)
    assert box_content(path.read_bytes(), b"colr")[:10] == kind + b"\0\1\0\1\0\1"
    with av.open(str(path)) as container:
        context = container.streams.video[0].codec_context
        assert context.color_primaries == context.color_trc == context.colorspace == 1
        assert context.color_range == 1


def test_prores_frame_headers_declare_rec_709(capsys, shot_file, tmp_path):
    """Editing programs read primaries, curve and matrix from the header of each frame."""
    export_shot(capsys, shot_file, tmp_path / "m.mov")
    headers = (tmp_path / "m.mov").read_bytes().split(b"icpf")[1:]
    assert [header[14:17] for header in headers] == [b"\1\1\1"] * len(FRAMES)


def flat_plates(folder):
    """Write frames of one color each and a slow ramp, which half-width chroma keeps exactly."""
    folder.mkdir()
    colors = [(0.18, 0.18, 0.18), (0.9, 0.05, 0.02), (0.02, 0.6, 0.1), (0.05, 0.1, 0.8)]
    ramp = np.linspace(0, 1, 64, dtype=np.float32)[None, :, None]
    camera = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
    for frame, color in zip(range(1001, 1006), [*colors, ramp], strict=True):
        picture = np.broadcast_to(np.asarray(color, np.float32), (32, 64, 3))
        channels = {n: np.ascontiguousarray(picture[..., i]) for i, n in enumerate("RGB")}
        depth = np.full((32, 64), 2.24, np.float32)
        write_file(folder / f"plate.{frame}.exr", channels | {"Z": depth}, **camera)
    return str(folder / "plate.####.exr")


@pytest.mark.parametrize(("suffix", "most", "mean"), [(".mov", 1.5, 0.75), (".mp4", 3.5, 1.5)])
def test_movie_colors_match_png_export(capsys, tmp_path, suffix, most, mean):
    """Compare code values of 255; ProRes has 10 bits, H.264 here 8 bits, of which video uses 220.

    The colors are saturated, and the view is the plain sRGB curve.
    """
    source = flat_plates(tmp_path / "plates")
    words = ("--focus-distance", "2.24", "--bokeh", "heat", "--quality", "draft", *PLAIN)
    export_shot(capsys, source, tmp_path / f"m{suffix}", *words)
    export_shot(capsys, source, tmp_path / "n.####.png", *words)
    movie_frames = decode_frames(tmp_path / f"m{suffix}")
    expected = np.stack([pixels(tmp_path / f"n.{frame}.png") for frame in range(1001, 1006)])
    assert np.abs(movie_frames - expected).max() <= most
    assert np.abs((movie_frames - expected).mean(axis=(1, 2))).max() < mean


def test_prores_frames_match_png_frames_in_order(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "m.mov", "--exposure=-1")
    export_shot(capsys, shot_file, tmp_path / "n.####.png", "--exposure=-1")
    expected = np.stack([pixels(tmp_path / f"n.{frame}.png") for frame in FRAMES])
    luma = np.array([0.2126, 0.7152, 0.0722])
    difference = (decode_frames(tmp_path / "m.mov") - expected) @ luma
    assert np.abs(difference).mean() < 2.0
    for frame, picture in enumerate(decode_frames(tmp_path / "m.mov")):
        distances = [np.abs(picture - expected_picture).mean() for expected_picture in expected]
        assert np.argmin(distances) == frame


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
@pytest.mark.parametrize("size", [(33, 17), (3, 5), (1, 1)])
def test_movie_of_odd_size_is_padded_to_even_size(capsys, tmp_path, suffix, size):
    (tmp_path / "plates").mkdir()
    for frame in (1001, 1002):
        write_plate(tmp_path / "plates" / f"plate.{frame}.exr", size=size)
    shot = shot_of(str(tmp_path / "plates" / "plate.####.exr"), (1001, 1002))
    write_shot(tmp_path / "s.heatlens.json", shot)
    export_shot(capsys, tmp_path / "s.heatlens.json", tmp_path / f"m{suffix}")
    movie_frames = decode_frames(tmp_path / f"m{suffix}")
    width, height = (side + side % 2 for side in size)
    assert movie_frames.shape == (2, height, width, 3)


@pytest.mark.parametrize(("words", "wider", "aspect"), [((), 1, 2), (("--desqueeze", "2"), 2, 1)])
def test_movie_declares_pixel_aspect_or_is_desqueezed(capsys, tmp_path, words, wider, aspect):
    source = write_plates(tmp_path / "plates", (1001, 1002), pixelAspectRatio=2.0)
    write_shot(tmp_path / "s.heatlens.json", shot_of(source, (1001, 1002)))
    export_shot(capsys, tmp_path / "s.heatlens.json", tmp_path / "m.mov", *words)
    with av.open(str(tmp_path / "m.mov")) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.sample_aspect_ratio) == (wider * WIDTH, aspect)


def test_burn_in_changes_lower_edge_of_movie_frames(capsys, shot_file, tmp_path):
    for name, words in (("a", ()), ("b", ("--burn-in",))):
        export_shot(capsys, shot_file, tmp_path / f"{name}.mov", *words)
    difference = np.abs(decode_frames(tmp_path / "a.mov") - decode_frames(tmp_path / "b.mov"))
    assert difference[:, -4:].max() > 20 > difference[:, :8].max()


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
def test_finished_movie_is_kept_and_forced_one_is_byte_identical(
    capsys, shot_file, tmp_path, suffix
):
    path = tmp_path / f"m{suffix}"
    export_shot(capsys, shot_file, path)
    first = path.read_bytes()
    assert "6 were finished before" in export_shot(capsys, shot_file, path)
    assert "6 frames written." in export_shot(capsys, shot_file, path, "--force")
    assert path.read_bytes() == first
    write_shot(shot_file, with_focus(read_shot(shot_file), 1004, 0.7))
    assert "6 frames written." in export_shot(capsys, shot_file, path)
    assert path.read_bytes() != first


def test_failed_movie_export_keeps_previous_movie(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "m.mov")
    before = files_in(tmp_path)
    (tmp_path / "plates" / "plate.1005.exr").write_bytes(b"no plate")
    assert "plate.1005.exr" in refused_export_message(capsys, shot_file, tmp_path / "m.mov")
    assert files_in(tmp_path) == before


def test_movie_export_refuses_frame_of_other_size(capsys, shot_file, tmp_path):
    write_plate(tmp_path / "plates" / "plate.1003.exr", size=(20, 30))
    message = refused_export_message(capsys, shot_file, tmp_path / "m.mov")
    assert "plate.1003.exr" in message and "20x30" in message and "32x18" in message
    assert "m.mov" not in files_in(tmp_path)


def test_encoder_error_is_reported_and_leaves_no_movie(capsys, shot_file, tmp_path, monkeypatch):
    refusing = replace(movies._CODECS[".mp4"], options={"profile": "baseline", "crf": "0"})
    monkeypatch.setitem(movies._CODECS, ".mp4", refusing)
    message = refused_export_message(capsys, shot_file, tmp_path / "m.mp4")
    assert "m.mp4 could not" in message
    assert "m.mp4" not in files_in(tmp_path)


def test_full_disk_leaves_no_movie(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "m.mov")
    size = (tmp_path / "m.mov").stat().st_size
    (tmp_path / "m.mov").unlink()
    before = files_in(tmp_path)
    process = start_heatlens_on_full_disk(size - 1, "export", shot_file, "-o", tmp_path / "m.mov")
    message = process.communicate(timeout=PATIENCE_S)[1]
    assert process.returncode == 2
    assert "m.mov could not" in message and "Traceback" not in message
    assert files_in(tmp_path) == before


def test_killed_movie_export_can_be_run_again(capsys, shot_file, tmp_path):
    export_shot(capsys, shot_file, tmp_path / "m.mov")
    expected_files = files_in(tmp_path)
    (tmp_path / "m.mov").unlink()
    process = start_heatlens("export", shot_file, "-o", tmp_path / "m.mov")
    while process.poll() is None and not list(tmp_path.glob(".heatlens-*.part")):
        time.sleep(0.001)
    process.kill()
    process.communicate(timeout=PATIENCE_S)
    assert len(files_in(tmp_path)) == 2 and "m.mov" not in files_in(tmp_path)
    export_shot(capsys, shot_file, tmp_path / "m.mov")
    assert files_in(tmp_path) == expected_files


def test_movie_export_refuses_display_with_other_primaries(capsys, shot_file, tmp_path):
    message = refused_export_message(
        capsys, shot_file, tmp_path / "m.mov", "--display", "Display P3 - Display"
    )
    assert "Rec.709" in message and "m.mov" not in files_in(tmp_path)


def test_export_without_pyav_refuses_movies_only(capsys, shot_file, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    assert "pip install 'heatlens[movie]'" in refused_export_message(
        capsys, shot_file, tmp_path / "m.mov"
    )
    export_shot(capsys, shot_file, tmp_path / "n.####.png")


@pytest.mark.parametrize(
    ("typed_rate", "rate"),
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
def test_exact_rate_returns_broadcast_fractions(typed_rate, rate):
    assert exact_rate(typed_rate) == rate


def test_ffmpeg_error_becomes_input_error_with_file_name():
    """An error of FFmpeg becomes an `InputError` whose message names the file."""
    with (
        pytest.raises(InputError, match=r"m\.mov could not be written as a movie \(Generic error"),
        movies._ffmpeg_errors_as_input_errors(movies.Path("m.mov"), av),
    ):
        raise av.error.ExternalError(542398533, "Generic error")
