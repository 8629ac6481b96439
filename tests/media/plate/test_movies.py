"""Frames of movies: each is the one asked for, with its colours, its timecode and its depth."""

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
from heatlens.media.plate.picture.display import srgb_decoded
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.depth_files import PlateFiles, depth_path_for
from heatlens.media.sequence.sequence import find_sequence, rescanned, stamp_of
from support.exr_files import rgb, write_file
from support.movies import (
    CODECS,
    HEIGHT,
    WIDTH,
    ramps,
    turned_clockwise,
    write_movie,
    write_sound,
)

COUNT = 40
AUTO = PlateOptions().picture_curve


def levels_in_order(path: Path) -> list[int]:
    """Return the mean of every frame as FFmpeg decodes them one after the other."""
    with av.open(str(path)) as container:
        frames = [frame.to_ndarray(format="rgb48le") for frame in container.decode(video=0)]
    return [round(float(frame.mean())) for frame in frames]


def near(value: float, levels: list[int]) -> int:
    return int(np.abs(np.asarray(levels) - value).argmin())


@pytest.mark.parametrize("codec", CODECS)
def test_any_frame_in_any_order_is_the_one_that_was_asked_for(tmp_path, codec):
    path = write_movie(tmp_path / f"clip{CODECS[codec][0]}", ramps(COUNT), codec)
    levels = levels_in_order(path)
    assert levels == sorted(levels) and len(set(levels)) == COUNT  # no two frames are alike
    movie = Movie(path)
    order = list(range(COUNT)) * 2
    random.Random(1).shuffle(order)
    got = [near(float(movie.frame(number).values.mean()), levels) for number in order]
    assert movie.count == COUNT and got == order


def test_threads_get_their_frames(tmp_path):
    path = write_movie(tmp_path / "clip.mp4", ramps(COUNT), "H.264")
    levels, movie = levels_in_order(path), Movie(path)
    order = [number for pair in range(0, COUNT, 2) for number in (pair + 1, pair)]
    with ThreadPoolExecutor(4) as threads:
        frames = list(threads.map(movie.frame, order))
    assert [near(float(frame.values.mean()), levels) for frame in frames] == order


def test_frames_of_a_movie_are_a_sequence(tmp_path):
    path = write_movie(tmp_path / "sh010.v2.mov", ramps(5))
    whole, moved = find_sequence(path), find_sequence(f"{path}@1001")
    assert whole.frames == whole.present == (1, 2, 3, 4, 5)
    assert moved.frames == (1001, 1002, 1003, 1004, 1005)
    assert find_sequence(whole.pattern) == whole == rescanned(whole) and whole.pattern == str(path)
    assert find_sequence(moved.pattern) == moved
    one = find_sequence(whole.path_at(3), whole=False)
    assert one.frames == (3,) and whole.frame_at(one.path_at(3)) == 3
    assert find_sequence(path, "2-4").frames == (2, 3, 4)


def test_a_changed_movie_is_read_again_and_its_frames_have_stamps_of_their_own(tmp_path):
    path = write_movie(tmp_path / "clip.mov", ramps(5))
    sequence = find_sequence(path)
    stamps = [stamp_of(sequence.path_at(frame)) for frame in sequence.frames]
    assert None not in stamps and len(set(stamps)) == 5
    assert stamp_of(sequence.path_at(2)) == stamp_of(find_sequence(f"{path}@11").path_at(12))
    write_movie(path, ramps(7))
    assert rescanned(sequence).frames == (1, 2, 3, 4, 5, 6, 7)
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
def test_white_is_one_and_black_zero_in_every_format(tmp_path, suffix, codec, pixel_format, bits):
    white, black = (np.full((HEIGHT, WIDTH, 3), value, np.uint16) for value in (0xFFFF, 0))
    options = {"crf": "1"} if codec == "H.264" else {}
    given = {"pixel_format": pixel_format, "options": options}
    path = write_movie(tmp_path / f"clip{suffix}", [white, black], codec, **given)
    for frame, expected in ((1, 1.0), (2, 0.0)):
        ((_, channels),) = color_parts(find_sequence(path).path_at(frame), AUTO)
        assert channels["G"] == pytest.approx(expected, abs=1.5 / 255 if bits == 8 else 4 / 1023)


def test_colours_follow_the_matrix_of_the_tag(tmp_path):
    """Source of the numbers: ITU-R BT.709 and BT.2020, for Y 120, Cb 140, Cr 150 of 8 bits."""
    stored = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    stored[:] = 120, 140, 150
    y, cb, cr = (120 - 16) / 219, (140 - 128) / 224, (150 - 128) / 224
    wanted = {
        1: (y + 1.5748 * cr, y - 0.1873 * cb - 0.4681 * cr, y + 1.8556 * cb),
        9: (y + 1.4746 * cr, y - 0.16455 * cb - 0.57135 * cr, y + 1.8814 * cb),
    }
    for matrix, colors in wanted.items():
        given = {"pixel_format": "yuv444p", "colorspace": matrix}
        path = write_movie(tmp_path / f"{matrix}.mkv", [stored] * 2, "FFV1", **given)
        frame = Movie(path).frame(1)
        assert frame.values[9, 9] / frame.white == pytest.approx(colors, abs=0.002)


@pytest.mark.parametrize(
    ("transfer", "signal", "light"),
    [
        *((1, 0.5, 0.2140), (13, 0.5, 0.2140), (8, 0.5, 0.5)),
        *((16, 0.5806, 1.0), (16, 0.7518, 1000 / 203), (18, 0.75, 1.0), (18, 0.5, 1 / 12 / 0.265)),
    ],
)
def test_the_tag_of_the_curve_tells_the_light(tmp_path, transfer, signal, light):
    """Signals and nits of PQ and HLG: ITU-R BT.2408, table 1; HLG of 50 % is a twelfth."""
    pixels = np.full((HEIGHT, WIDTH, 3), round(signal * 0xFFFF), np.uint16)
    tags = {"color_trc": transfer, "color_primaries": 9 if transfer >= 16 else 1}
    given = {"pixel_format": "gbrp16le"} | tags
    path = write_movie(tmp_path / "clip.mkv", [pixels] * 2, "FFV1", **given)
    ((header, channels),) = color_parts(find_sequence(path).path_at(2), AUTO)
    assert channels["R"] == pytest.approx(light, rel=0.01)
    assert (header.get("chromaticities") == REC2020.chromaticities) == (transfer >= 16)


def test_alpha_of_prores_4444_premultiplies(tmp_path):
    pixels = np.full((HEIGHT, WIDTH, 4), 40000, np.uint16)
    pixels[..., 3] = np.linspace(0, 0xFFFF, WIDTH).astype(np.uint16)
    given = {"pixel_format": "yuva444p10le", "options": {"profile": "4"}}
    path = write_movie(tmp_path / "clip.mov", [pixels] * 2, **given)
    ((_, channels),) = color_parts(find_sequence(path).path_at(2), AUTO)
    alpha = pixels[..., 3] / 0xFFFF
    light = float(srgb_decoded(40000 / 0xFFFF))
    assert channels["A"] == pytest.approx(alpha, abs=0.002) and channels["A"].max() == 1.0
    assert channels["G"] == pytest.approx(alpha * light, abs=0.006)


@pytest.mark.parametrize("encoder", ["libvpx-vp9", "libvpx"])
@pytest.mark.parametrize("order", [(2, 5, 1, 6), (6, 1)])
def test_alpha_of_webm_is_read_in_any_order(tmp_path, encoder, order):
    pixels = []
    for at in range(6):
        pixels.append(np.full((HEIGHT, WIDTH, 4), 30000, np.uint16))
        pixels[-1][..., 3] = np.linspace(0, 0xFFFF - 8000 * at, WIDTH).astype(np.uint16)
    given = {"pixel_format": "yuva420p", "encoder": encoder, "options": {"auto-alt-ref": "0"}}
    path = write_movie(tmp_path / "clip.webm", pixels, "VP9", **given)
    sequence = find_sequence(path)
    for frame in order:
        ((_, channels),) = color_parts(sequence.path_at(frame), AUTO)
        assert channels["A"] == pytest.approx(pixels[frame - 1][..., 3] / 0xFFFF, abs=0.05)


def test_every_frame_has_its_timecode_and_the_rate(tmp_path):
    path = write_movie(tmp_path / "clip.mov", ramps(30), timecode="10:00:00:20", rate=25)
    sequence = find_sequence(f"{path}@1001")
    for frame, timecode in ((1001, "10:00:00:20"), (1006, "10:00:01:00"), (1030, "10:00:01:24")):
        header = picture_header(sequence.path_at(frame))
        assert str(timecode_of(header)) == timecode and rate_at(header) == 25.0


def test_a_movie_of_a_phone_stands_upright(tmp_path):
    pixels = np.zeros((HEIGHT, WIDTH, 3), np.uint16)
    pixels[: HEIGHT // 2, : WIDTH // 2] = 0xFFFF  # top left, shown at the top right
    path = turned_clockwise(write_movie(tmp_path / "clip.mov", [pixels] * 2))
    values = Movie(path).frame(0).values[:, :, 0] > 1 << 15
    assert values.shape == (WIDTH, HEIGHT)
    assert values[4, -4] and not values[4, 4] and not values[-4, -4]


def test_frames_at_uneven_times_are_counted_in_order_and_said(tmp_path):
    even = write_movie(tmp_path / "even.mp4", ramps(8), "H.264")
    uneven = write_movie(
        tmp_path / "uneven.mp4", ramps(8), "H.264", times=(0, 1, 2, 6, 7, 8, 15, 16)
    )
    assert movie_at(even).is_even and not movie_at(uneven).is_even
    levels, movie = levels_in_order(uneven), movie_at(uneven)
    assert [near(movie.frame(at).values.mean(), levels) for at in range(8)] == list(range(8))
    ((header, _),) = color_parts(find_sequence(uneven).path_at(1), AUTO)
    assert "on average" in str(header["heatlens:pictureFacts"])


def depth_frames(folder: Path, first: int, count: int) -> str:
    for at in range(count):
        z = np.full((HEIGHT, WIDTH), 1.0 + at, np.float32)
        write_file(folder / f"z.{first + at}.exr", rgb(HEIGHT, WIDTH) | {"Z": z})
    return str(folder / "z.####.exr")


def test_depth_goes_with_a_movie_in_order_first_with_first(tmp_path):
    movie = find_sequence(f"{write_movie(tmp_path / 'clip.mov', ramps(4))}@31")
    frames = depth_frames(tmp_path, 1001, 4)
    for at in range(4):
        path = movie.path_at(31 + at)
        assert depth_path_for(path, frames).name == f"z.{1001 + at}.exr"
        assert PlateFiles([frames])(path) == (path, tmp_path / f"z.{1001 + at}.exr")
        plate = read_plate(path, PlateOptions(depth_source=frames))
        assert plate.depth_m == pytest.approx(1.0 + at)


def test_depth_of_a_second_movie_is_that_of_the_same_frame(tmp_path):
    colors = write_movie(tmp_path / "clip.mov", ramps(6))
    depths = write_movie(tmp_path / "z.mkv", ramps(6), "FFV1", pixel_format="gray16le")
    options = PlateOptions(
        depth_source=str(depths), depth_convention=DepthConvention.NORMALIZED, near_m=1, far_m=2
    )
    sequence = find_sequence(colors)
    for at, ramp in enumerate(ramps(6)):
        plate = read_plate(sequence.path_at(at + 1), options)
        assert plate.depth_m == pytest.approx(1 + ramp[..., 0] / 0xFFFF, abs=3e-3)
    alone = read_plate(colors, options)  # the movie itself is its first frame
    assert alone.depth_m == pytest.approx(1 + ramps(6)[0][..., 0] / 0xFFFF, abs=3e-3)


def test_a_depth_with_fewer_frames_is_named(tmp_path):
    movie = find_sequence(write_movie(tmp_path / "clip.mov", ramps(4)))
    frames = depth_frames(tmp_path, 1001, 3)
    with pytest.raises(InputError, match=r"z\.####\.exr has 3 frames, but .* is number 4"):
        depth_path_for(movie.path_at(4), frames)


def cut(path: Path, part: float) -> Path:
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * part)])
    return path


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda folder: cut(write_movie(folder / "c.mov", ramps(9)), 0.5), "cannot be read"),
        (lambda folder: cut(write_movie(folder / "c.mkv", ramps(9), "FFV1"), 0.02), "c.mkv"),
        (lambda folder: cut(write_movie(folder / "c.mov", ramps(9)), 0.0), "cannot be read"),
        (lambda folder: write_sound(folder / "c.mp4"), "no moving picture"),
        (lambda folder: folder / "c.mov", "cannot be found|is not there|is neither"),
    ],
    ids=["cut", "head alone", "empty", "sound alone", "missing"],
)
def test_a_movie_that_cannot_be_read_is_one_sentence(tmp_path, make, says):
    path = make(tmp_path)
    with pytest.raises(InputError, match=says) as caught:
        find_sequence(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_a_movie_whose_index_is_longer_than_the_file_is_cut_short(tmp_path):
    path = write_movie(tmp_path / "c.mov", ramps(9))
    with av.open(str(path)) as container:
        entries = list(container.streams.video[0].index_entries)
    data = bytearray(path.read_bytes())
    at = data.index(b"stsz") + 16 + 4 * 8  # the size of the last frame
    data[at : at + 4] = (len(data) * 2).to_bytes(4, "big")
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"it has 8 of its {len(entries)} frames"):
        find_sequence(path)


def test_text_that_names_other_files_is_no_movie(tmp_path):
    """FFmpeg would follow a playlist wherever it points, whatever its extension."""
    secret = write_movie(tmp_path / "secret.mp4", ramps(3), "H.264")
    path = tmp_path / "list.mp4"
    path.write_text(f"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{secret}\n#EXT-X-ENDLIST\n")
    with pytest.raises(InputError, match="cannot be read"):
        find_sequence(path)


def test_random_damage_gives_frames_or_one_sentence(tmp_path):
    whole = write_movie(tmp_path / "c.mp4", ramps(12), "H.264").read_bytes()
    path, chance = tmp_path / "damaged.mp4", random.Random(3)
    for _ in range(120):
        data = bytearray(whole)
        for _ in range(chance.randrange(1, 20)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        path.write_bytes(data)
        try:
            movie = Movie(path)
            for number in (0, 7, movie.count - 1):
                assert movie.frame(min(number, movie.count - 1)).values.ndim == 3
        except InputError as error:
            assert "\n" not in str(error) and str(path) in str(error)
