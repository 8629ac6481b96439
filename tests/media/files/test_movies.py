"""Test frames of movies: the right frame, with its colors, timecode and depth."""

import random
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import av
import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.movie_read import Movie, movie_at
from heatlens.media.plate.header.primaries import REC2020
from heatlens.media.plate.header.timecode import rate_at, timecode_of
from heatlens.media.plate.parts.picture_parts import color_parts, picture_header
from heatlens.media.plate.picture.display import decode_srgb
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.depth_files import PlateFiles, depth_path_for
from heatlens.media.sequence.sequence import stamp_of
from heatlens.media.sequence.sequence_search import find_sequence, rescan
from support.exr_files import rgb, write_file
from support.movies import (
    CODECS,
    HEIGHT,
    WIDTH,
    mark_rotated_clockwise,
    ramps,
    write_movie,
    write_sound,
)

COUNT = 40
AUTO = PlateOptions().picture_curve


def decoded_levels(path: Path) -> list[int]:
    """Return the mean of each frame as FFmpeg decodes them in order."""
    with av.open(str(path)) as container:
        frames = [frame.to_ndarray(format="rgb48le") for frame in container.decode(video=0)]
    return [round(float(frame.mean())) for frame in frames]


def nearest_level(value: float, levels: list[int]) -> int:
    return int(np.abs(np.asarray(levels) - value).argmin())


@pytest.mark.parametrize("codec", CODECS)
def test_movie_returns_requested_frame_in_any_order(tmp_path, codec):
    path = write_movie(tmp_path / f"clip{CODECS[codec][0]}", ramps(COUNT), codec)
    levels = decoded_levels(path)
    assert levels == sorted(levels) and len(set(levels)) == COUNT  # no two frames are alike
    movie = Movie(path)
    order = list(range(COUNT)) * 2
    random.Random(1).shuffle(order)
    frame_numbers = [
        nearest_level(float(movie.frame(number).values.mean()), levels) for number in order
    ]
    assert movie.count == COUNT and frame_numbers == order


def test_movie_returns_right_frames_to_threads(tmp_path):
    path = write_movie(tmp_path / "clip.mp4", ramps(COUNT), "H.264")
    levels, movie = decoded_levels(path), Movie(path)
    order = [number for pair in range(0, COUNT, 2) for number in (pair + 1, pair)]
    with ThreadPoolExecutor(4) as threads:
        frames = list(threads.map(movie.frame, order))
    assert [nearest_level(float(frame.values.mean()), levels) for frame in frames] == order


def test_find_sequence_of_movie_lists_its_frames(tmp_path):
    path = write_movie(tmp_path / "sh010.v2.mov", ramps(5))
    movie_sequence, offset_sequence = find_sequence(path), find_sequence(f"{path}@1001")
    assert movie_sequence.frames == movie_sequence.present == (1, 2, 3, 4, 5)
    assert offset_sequence.frames == (1001, 1002, 1003, 1004, 1005)
    assert find_sequence(movie_sequence.pattern) == movie_sequence == rescan(
        movie_sequence
    ) and movie_sequence.pattern == str(path)
    assert find_sequence(offset_sequence.pattern) == offset_sequence
    single_frame = find_sequence(movie_sequence.path_at(3), whole=False)
    assert single_frame.frames == (3,) and movie_sequence.frame_at(single_frame.path_at(3)) == 3
    assert find_sequence(path, "2-4").frames == (2, 3, 4)


def test_changed_movie_is_rescanned_and_frames_get_new_stamps(tmp_path):
    path = write_movie(tmp_path / "clip.mov", ramps(5))
    sequence = find_sequence(path)
    stamps = [stamp_of(sequence.path_at(frame)) for frame in sequence.frames]
    assert None not in stamps and len(set(stamps)) == 5
    assert stamp_of(sequence.path_at(2)) == stamp_of(find_sequence(f"{path}@11").path_at(12))
    write_movie(path, ramps(7))
    assert rescan(sequence).frames == (1, 2, 3, 4, 5, 6, 7)
    assert stamp_of(sequence.path_at(2)) not in stamps


@pytest.mark.parametrize(
    ("suffix", "codec", "pixel_format", "bits"),
    [
        (".mov", "ProRes", "yuv422p10le", 10),
        (".mp4", "H.264", "yuv420p", 8),
        (".mkv", "FFV1", "yuv444p16le", 16),
        (".mkv", "FFV1", "gray10le", 10),
        (".mkv", "FFV1", "gray16le", 16),
        (".mkv", "FFV1", "gbrp10le", 10),
        (".mkv", "FFV1", "bgr0", 8),
    ],
)
def test_movie_white_is_one_and_black_zero_in_every_format(
    tmp_path, suffix, codec, pixel_format, bits
):
    white, black = (np.full((HEIGHT, WIDTH, 3), value, np.uint16) for value in (0xFFFF, 0))
    options = {"crf": "1"} if codec == "H.264" else {}
    settings = {"pixel_format": pixel_format, "options": options}
    path = write_movie(tmp_path / f"clip{suffix}", [white, black], codec, **settings)
    for frame, expected in ((1, 1.0), (2, 0.0)):
        ((_, channels),) = color_parts(find_sequence(path).path_at(frame), AUTO)
        assert channels["G"] == pytest.approx(expected, abs=1.5 / 255 if bits == 8 else 4 / 1023)


def test_movie_colors_follow_tagged_matrix(tmp_path):
    """The numbers are those of ITU-R BT.709 and BT.2020, for Y 120, Cb 140, Cr 150 of 8 bits."""
    stored = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    stored[:] = 120, 140, 150
    y, cb, cr = (120 - 16) / 219, (140 - 128) / 224, (150 - 128) / 224
    expected_colors = {
        1: (y + 1.5748 * cr, y - 0.1873 * cb - 0.4681 * cr, y + 1.8556 * cb),
        9: (y + 1.4746 * cr, y - 0.16455 * cb - 0.57135 * cr, y + 1.8814 * cb),
    }
    for matrix, colors in expected_colors.items():
        settings = {"pixel_format": "yuv444p", "colorspace": matrix}
        path = write_movie(tmp_path / f"{matrix}.mkv", [stored] * 2, "FFV1", **settings)
        frame = Movie(path).frame(1)
        assert frame.values[9, 9] / frame.white == pytest.approx(colors, abs=0.002)


@pytest.mark.parametrize(
    ("transfer", "signal", "light"),
    [
        *((1, 0.5, 0.2140), (13, 0.5, 0.2140), (8, 0.5, 0.5)),
        *((16, 0.5806, 1.0), (16, 0.7518, 1000 / 203), (18, 0.75, 1.0), (18, 0.5, 1 / 12 / 0.265)),
    ],
)
def test_movie_light_follows_tagged_transfer_curve(tmp_path, transfer, signal, light):
    """Signals and nits of PQ and HLG: ITU-R BT.2408, table 1; HLG of 50 % is a twelfth."""
    pixels = np.full((HEIGHT, WIDTH, 3), round(signal * 0xFFFF), np.uint16)
    tags = {"color_trc": transfer, "color_primaries": 9 if transfer >= 16 else 1}
    settings = {"pixel_format": "gbrp16le"} | tags
    path = write_movie(tmp_path / "clip.mkv", [pixels] * 2, "FFV1", **settings)
    ((header, channels),) = color_parts(find_sequence(path).path_at(2), AUTO)
    assert channels["R"] == pytest.approx(light, rel=0.01)
    assert (header.get("chromaticities") == REC2020.chromaticities) == (transfer >= 16)


def test_movie_alpha_of_prores_4444_premultiplies_color(tmp_path):
    pixels = np.full((HEIGHT, WIDTH, 4), 40000, np.uint16)
    pixels[..., 3] = np.linspace(0, 0xFFFF, WIDTH).astype(np.uint16)
    settings = {"pixel_format": "yuva444p10le", "options": {"profile": "4"}}
    path = write_movie(tmp_path / "clip.mov", [pixels] * 2, **settings)
    ((_, channels),) = color_parts(find_sequence(path).path_at(2), AUTO)
    alpha = pixels[..., 3] / 0xFFFF
    light = float(decode_srgb(40000 / 0xFFFF))
    assert channels["A"] == pytest.approx(alpha, abs=0.002) and channels["A"].max() == 1.0
    assert channels["G"] == pytest.approx(alpha * light, abs=0.006)


@pytest.mark.parametrize("encoder", ["libvpx-vp9", "libvpx"])
@pytest.mark.parametrize("order", [(2, 5, 1, 6), (6, 1)])
def test_movie_alpha_of_webm_is_read_in_any_order(tmp_path, encoder, order):
    pixels = []
    for at in range(6):
        pixels.append(np.full((HEIGHT, WIDTH, 4), 30000, np.uint16))
        pixels[-1][..., 3] = np.linspace(0, 0xFFFF - 8000 * at, WIDTH).astype(np.uint16)
    settings = {"pixel_format": "yuva420p", "encoder": encoder, "options": {"auto-alt-ref": "0"}}
    path = write_movie(tmp_path / "clip.webm", pixels, "VP9", **settings)
    sequence = find_sequence(path)
    for frame in order:
        ((_, channels),) = color_parts(sequence.path_at(frame), AUTO)
        assert channels["A"] == pytest.approx(pixels[frame - 1][..., 3] / 0xFFFF, abs=0.05)


def test_movie_frames_have_timecode_and_rate(tmp_path):
    path = write_movie(tmp_path / "clip.mov", ramps(30), timecode="10:00:00:20", rate=25)
    sequence = find_sequence(f"{path}@1001")
    for frame, timecode in ((1001, "10:00:00:20"), (1006, "10:00:01:00"), (1030, "10:00:01:24")):
        header = picture_header(sequence.path_at(frame))
        assert str(timecode_of(header)) == timecode and rate_at(header) == 25.0


def test_movie_frame_is_rotated_as_tagged(tmp_path):
    pixels = np.zeros((HEIGHT, WIDTH, 3), np.uint16)
    pixels[: HEIGHT // 2, : WIDTH // 2] = 0xFFFF  # top left, shown at the top right
    path = mark_rotated_clockwise(write_movie(tmp_path / "clip.mov", [pixels] * 2))
    values = Movie(path).frame(0).values[:, :, 0] > 1 << 15
    assert values.shape == (WIDTH, HEIGHT)
    assert values[4, -4] and not values[4, 4] and not values[-4, -4]


def test_movie_with_uneven_frame_times_is_counted_in_order_with_a_note(tmp_path):
    even = write_movie(tmp_path / "even.mp4", ramps(8), "H.264")
    uneven = write_movie(
        tmp_path / "uneven.mp4", ramps(8), "H.264", times=(0, 1, 2, 6, 7, 8, 15, 16)
    )
    assert movie_at(even).is_even and not movie_at(uneven).is_even
    levels, movie = decoded_levels(uneven), movie_at(uneven)
    assert [nearest_level(movie.frame(at).values.mean(), levels) for at in range(8)] == list(
        range(8)
    )
    ((header, _),) = color_parts(find_sequence(uneven).path_at(1), AUTO)
    assert "on average" in str(header["heatlens:pictureFacts"])


def write_depth_frames(folder: Path, first: int, count: int) -> str:
    for at in range(count):
        z = np.full((HEIGHT, WIDTH), 1.0 + at, np.float32)
        write_file(folder / f"z.{first + at}.exr", rgb(HEIGHT, WIDTH) | {"Z": z})
    return str(folder / "z.####.exr")


def test_depth_frames_match_movie_frames_by_position(tmp_path):
    movie = find_sequence(f"{write_movie(tmp_path / 'clip.mov', ramps(4))}@31")
    frames = write_depth_frames(tmp_path, 1001, 4)
    for at in range(4):
        path = movie.path_at(31 + at)
        assert depth_path_for(path, frames).name == f"z.{1001 + at}.exr"
        assert PlateFiles([frames])(path) == (path, tmp_path / f"z.{1001 + at}.exr")
        plate = read_plate(path, PlateOptions(depth_source=frames))
        assert plate.depth_m == pytest.approx(1.0 + at)


def test_depth_movie_matches_color_movie_by_frame(tmp_path):
    colors = write_movie(tmp_path / "clip.mov", ramps(6))
    depths = write_movie(tmp_path / "z.mkv", ramps(6), "FFV1", pixel_format="gray16le")
    options = PlateOptions(
        depth_source=str(depths), depth_convention=DepthConvention.NORMALIZED, near_m=1, far_m=2
    )
    sequence = find_sequence(colors)
    for at, ramp in enumerate(ramps(6)):
        plate = read_plate(sequence.path_at(at + 1), options)
        assert plate.depth_m == pytest.approx(1 + ramp[..., 0] / 0xFFFF, abs=3e-3)
    first_plate = read_plate(colors, options)  # the movie itself is its first frame
    assert first_plate.depth_m == pytest.approx(1 + ramps(6)[0][..., 0] / 0xFFFF, abs=3e-3)


def test_depth_with_fewer_frames_than_movie_is_reported(tmp_path):
    movie = find_sequence(write_movie(tmp_path / "clip.mov", ramps(4)))
    frames = write_depth_frames(tmp_path, 1001, 3)
    with pytest.raises(InputError, match=r"z\.####\.exr has 3 frames, but .* frame number 4"):
        depth_path_for(movie.path_at(4), frames)


def truncate(path: Path, share: float) -> Path:
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    return path


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda folder: truncate(write_movie(folder / "c.mov", ramps(9)), 0.5), "cannot be read"),
        (lambda folder: truncate(write_movie(folder / "c.mkv", ramps(9), "FFV1"), 0.02), "c.mkv"),
        (lambda folder: truncate(write_movie(folder / "c.mov", ramps(9)), 0.0), "cannot be read"),
        (lambda folder: write_sound(folder / "c.mp4"), "no moving picture"),
        (lambda folder: folder / "c.mov", "cannot be found|is not there|is neither"),
    ],
    ids=["cut", "head alone", "empty", "sound alone", "missing"],
)
def test_find_sequence_reports_unreadable_movie_in_one_sentence(tmp_path, make, says):
    path = make(tmp_path)
    with pytest.raises(InputError, match=says) as caught:
        find_sequence(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_find_sequence_rejects_movie_shorter_than_its_index(tmp_path):
    path = write_movie(tmp_path / "c.mov", ramps(9))
    with av.open(str(path)) as container:
        entries = list(container.streams.video[0].index_entries)
    data = bytearray(path.read_bytes())
    at = data.index(b"stsz") + 16 + 4 * 8  # the size of the last frame
    data[at : at + 4] = (len(data) * 2).to_bytes(4, "big")
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"it has 8 of its {len(entries)} frames"):
        find_sequence(path)


def test_find_sequence_rejects_playlist_named_as_movie(tmp_path):
    """FFmpeg would follow a playlist wherever it points, whatever its suffix."""
    secret = write_movie(tmp_path / "secret.mp4", ramps(3), "H.264")
    path = tmp_path / "list.mp4"
    path.write_text(f"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{secret}\n#EXT-X-ENDLIST\n")
    with pytest.raises(InputError, match="cannot be read"):
        find_sequence(path)


def test_damaged_movie_gives_frames_or_one_sentence(tmp_path):
    movie_bytes = write_movie(tmp_path / "c.mp4", ramps(12), "H.264").read_bytes()
    path, rng = tmp_path / "damaged.mp4", random.Random(3)
    for _ in range(120):
        data = bytearray(movie_bytes)
        for _ in range(rng.randrange(1, 20)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(data)
        try:
            movie = Movie(path)
            for number in (0, 7, movie.count - 1):
                assert movie.frame(min(number, movie.count - 1)).values.ndim == 3
        except InputError as error:
            assert "\n" not in str(error) and str(path) in str(error)
