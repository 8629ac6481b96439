"""Test photos and frames with a depth map in a file of its own."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.media.color.input_space import input_space_of
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.parts.header_read import read_color_header
from heatlens.media.plate.picture.display import decode_srgb, encode_srgb
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.depth_files import pair_picture_with_depth
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file
from support.gui import gui_of
from support.picture_files import (
    HEIGHT,
    LARGEST,
    WIDTH,
    colors,
    disparity,
    display_p3,
    jpeg_with_gdepth,
    metres,
    save,
    save_16_bits_of_color,
    whole,
)

NEAR_M, FAR_M = 1.0, 10.0


@pytest.fixture
def photo(tmp_path):
    return save(tmp_path / "photo.png", colors())


@pytest.fixture
def depth_map(tmp_path):
    values = disparity(metres(), NEAR_M, FAR_M)
    return save(tmp_path / "map.png", whole(values, "u2"))


def plate_of(photo, depth, **options):
    return read_plate(photo, PlateOptions(depth_source=str(depth), **options))


@given(st.lists(st.floats(0, 1, width=32), min_size=1, max_size=40))
def test_decode_srgb_inverts_encode_srgb(values):
    np.testing.assert_allclose(decode_srgb(encode_srgb(values)), values, atol=2e-6)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".bmp", ".webp", ".tga"])
def test_read_plate_decodes_8_bits_as_srgb_with_note(tmp_path, depth_map, suffix):
    options = {"lossless": True} if suffix == ".webp" else {}
    plate = plate_of(save(tmp_path / f"p{suffix}", colors(), **options), depth_map)
    np.testing.assert_allclose(plate.color[..., :3], decode_srgb(colors() / 255), rtol=1e-6)
    assert not plate.has_alpha
    assert any("taken as sRGB" in n and "--picture-curve linear" in n for n in plate.notes)


def test_read_plate_accepts_avif_of_8_bits_only(tmp_path, depth_map):
    path = save(tmp_path / "p.avif", np.full(colors().shape, 128, np.uint8), quality=100)
    plate = plate_of(path, depth_map)
    np.testing.assert_allclose(plate.color[..., :3], decode_srgb(128 / 255), atol=0.01)
    data = bytearray(path.read_bytes())
    data[data.find(b"av1C") + 6] |= 0b0100_0000  # high_bitdepth
    path.write_bytes(data)
    with pytest.raises(InputError, match="more than 8 bits a channel"):
        plate_of(path, depth_map)


def test_read_plate_uses_given_picture_curve(photo, depth_map):
    plate = plate_of(photo, depth_map, picture_curve="linear")
    np.testing.assert_allclose(plate.color[..., :3], colors() / np.float32(255), rtol=1e-6)
    assert not any("sRGB" in note for note in plate.notes)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_read_plate_keeps_16_bits_of_color(tmp_path, depth_map, suffix):
    values = (colors().astype("u2") * 256 + 77).astype("u2")
    plate = plate_of(save_16_bits_of_color(tmp_path / f"c{suffix}", values), depth_map)
    np.testing.assert_allclose(plate.color[..., :3], decode_srgb(values / 65535), rtol=1e-5)


def test_read_plate_takes_floating_point_as_light(tmp_path, depth_map):
    values = (colors() / np.float32(16)).astype(np.float32)
    plate = plate_of(save_16_bits_of_color(tmp_path / "f.tif", values), depth_map)
    np.testing.assert_array_equal(plate.color[..., :3], values)
    assert any("scene-linear light" in note for note in plate.notes)


def test_read_plate_of_16_bits_without_library_names_extra(tmp_path, depth_map, monkeypatch):
    path = save_16_bits_of_color(tmp_path / "c.png", colors().astype("u2") * 257)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"heatlens\[pictures\]"):
        plate_of(path, depth_map)


def test_read_plate_premultiplies_alpha_in_linear_light(tmp_path, depth_map):
    values = np.dstack([colors(), np.full((HEIGHT, WIDTH), 51, "u1")])
    plate = plate_of(save(tmp_path / "a.png", values), depth_map)
    assert plate.has_alpha and plate.color[0, 0, 3] == pytest.approx(0.2)
    np.testing.assert_allclose(
        plate.color[..., :3], 0.2 * decode_srgb(colors() / 255), rtol=1e-5, atol=1e-9
    )


def test_read_plate_uses_primaries_of_photo_profile(tmp_path, depth_map):
    path = save(tmp_path / "p3.jpg", colors(), icc_profile=display_p3())
    assert input_space_of(None, read_color_header(path)).name == "linear P3-D65"
    assert input_space_of(None, plate_of(path, depth_map).attributes).name == "linear P3-D65"


def test_read_plate_takes_lens_from_exif(tmp_path, depth_map):
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA405] = 26  # focal length for 35 mm film, in the Exif block
    camera = plate_of(save(tmp_path / "e.jpg", colors(), exif=exif), depth_map).camera
    assert (camera.focal_length_mm, camera.sensor_width_mm, camera.f_stop) == (26, 36, None)


# Depth in a file of its own


@pytest.mark.parametrize("kind", ["u1", "u2"])
@pytest.mark.parametrize(
    ("convention", "made"),
    [
        ("disparity", lambda z: disparity(z, NEAR_M, FAR_M)),
        ("disparity-inverted", lambda z: 1 - disparity(z, NEAR_M, FAR_M)),
        ("normalized", lambda z: (z - NEAR_M) / (FAR_M - NEAR_M)),
        ("normalized-inverted", lambda z: (FAR_M - z) / (FAR_M - NEAR_M)),
    ],
)
def test_read_plate_converts_integer_maps_between_two_ends(photo, tmp_path, kind, convention, made):
    path = save(tmp_path / "d.png", whole(made(metres()), kind))
    plate = plate_of(photo, path, depth_convention=convention, near_m=NEAR_M, far_m=FAR_M)
    depth = np.where(np.isinf(plate.depth_m), FAR_M, plate.depth_m)
    step = 1 / LARGEST[kind]
    is_disparity = DepthConvention(convention).facts.is_disparity
    error = np.abs(1 / depth - 1 / metres()) if is_disparity else np.abs(depth - metres())
    assert error.max() <= (0.9 if is_disparity else 9.0) * step
    assert plate.depth.convention == convention and not plate.depth.question


def test_read_plate_converts_16_bit_millimeters(photo, tmp_path):
    millimetres = np.round(1000 * metres()).astype("u2")
    millimetres[0, 0] = 0  # nothing measured
    path = save(tmp_path / "kinect.png", millimetres)
    plate = plate_of(photo, path, scene_unit_m=1e-3)
    assert plate.depth.convention == "distance" and plate.depth.infinite_count == 0
    assert plate.depth_m[0, 0] in (plate.depth_m[0, 1], plate.depth_m[1, 0], plate.depth_m[1, 1])
    np.testing.assert_allclose(plate.depth_m[1:], metres()[1:], atol=6e-4)


@pytest.mark.parametrize("suffix", [".tif", ".pfm", ".npy"])
def test_read_plate_reads_floating_point_meters(photo, tmp_path, suffix):
    path, values = tmp_path / f"d{suffix}", metres().astype(np.float32)
    np.save(path, values) if suffix == ".npy" else save(path, values)
    plate = plate_of(photo, path, depth_convention="distance")
    np.testing.assert_allclose(plate.depth_m, values, rtol=1e-6)


def test_read_plate_asks_whether_white_or_black_is_near(photo, tmp_path, capsys):
    """A map does not name its ends: slopes that are even in 1/z are so with either end near."""
    disparities = disparity(metres(), NEAR_M, FAR_M)
    for name, values in (("white", disparities), ("black", 1 - disparities)):
        save(tmp_path / f"{name}.png", whole(values, "u2"))
    words = ["render", photo, "-o", tmp_path / "o.png", "--f-stop", 2, "--focus-distance", 2]
    words += ["--focal-length", 50, "--near", NEAR_M, "--far", FAR_M, "--depth"]
    for name, convention in (("white", "disparity"), ("black", "disparity-inverted")):
        path = tmp_path / f"{name}.png"
        stderr = stderr_of_run(capsys, 0, *words, path, "--verbose")
        assert stderr.count("is white near in it, or black?") == stderr.count("run evenly") == 1
        assert "disparity-inverted where black is near" in stderr_of_run(
            capsys, 2, *words, path, "--strict"
        )
        plate_options = {
            "depth_convention": convention,
            "near_m": NEAR_M,
            "far_m": FAR_M,
            "strict": True,
        }
        plate = plate_of(photo, path, **plate_options)
        np.testing.assert_allclose(1 / plate.depth_m, 1 / metres(), atol=2e-5)
        assert not plate.depth.question
    backwards = ["--near", FAR_M, "--far", NEAR_M]
    stderr = stderr_of_run(capsys, 2, *words, tmp_path / "black.png", *backwards)
    assert "set with --depth-convention" in stderr


def test_info_prints_depth_reading_once(photo, tmp_path, capsys):
    for name, values in (("slopes", disparity(metres(), 1, 10)), ("levels", metres() < 1.5)):
        path = save(tmp_path / f"{name}.png", whole(values, "u1"))
        assert main(["info", str(photo), "--depth", str(path)]) == 0
        stdout = " ".join(capsys.readouterr().out.split())
        plate = plate_of(photo, path)
        for words in (plate.depth.why, "--near and --far"):
            assert stdout.count(words) == 1


def test_read_plate_scales_floating_point_disparity(photo, tmp_path):
    path = tmp_path / "midas.npy"
    np.save(path, (300 + 5000 * disparity(metres(), NEAR_M, FAR_M)).astype(np.float32))
    plate = plate_of(photo, path, depth_convention="disparity", near_m=NEAR_M, far_m=FAR_M)
    np.testing.assert_allclose(plate.depth_m, metres(), rtol=1e-4)
    assert any("separately in every frame" in note for note in plate.notes)


def test_read_plate_asks_about_depth_map_without_hints(photo, tmp_path, capsys):
    levels = np.where(metres() < 1.5, 65535, 0).astype("u2")  # nothing slopes that could tell
    depth_map = save(tmp_path / "levels.png", levels)
    plate = plate_of(photo, depth_map)
    assert plate.depth.convention == "disparity"
    for words in (
        "is it disparity",
        "disparity-inverted (black near)",
        "--near and --far",
        "distance with --scene-unit",
    ):
        assert words in plate.depth.question
    assert "taken as 1 m and 10 m" in plate.depth.why
    assert set(plate.depth_m.flat) == {1.0, 10.0}
    words = ["render", photo, "--depth", depth_map, "-o", tmp_path / "o.png", "--f-stop", 2]
    words += ["--focus-distance", 2, "--focal-length", 50]
    assert "sharp: --depth-convention disparity-inverted" in stderr_of_run(capsys, 0, *words)
    assert "is it disparity" in stderr_of_run(capsys, 2, *words, "--strict")
    words += ["--depth-convention", "disparity"]
    assert "Give --near and --far" in stderr_of_run(capsys, 2, *words, "--strict")
    ends = ["--near", 1, "--far", 10]
    assert "?" not in stderr_of_run(capsys, 0, *words, "--strict", *ends)


def test_read_plate_enlarges_smaller_depth_map_by_nearest_value(photo, tmp_path):
    small = metres()[::2, ::2].astype(np.float32)
    path = tmp_path / "small.npy"
    np.save(path, small)
    plate = plate_of(photo, path, depth_convention="distance")
    assert plate.depth_m.shape == (HEIGHT, WIDTH) and set(plate.depth_m.flat) == set(small.flat)
    assert any("18 x 12" in note for note in plate.notes)
    np.save(path, metres()[:, ::2].astype(np.float32))
    with pytest.raises(InputError, match="different display windows"):
        plate_of(photo, path, depth_convention="distance")


def test_read_plate_rejects_colored_depth_map(photo, tmp_path):
    with pytest.raises(InputError, match=r"coloured.*grey"):
        plate_of(photo, save(tmp_path / "inferno.png", colors()))
    grey = np.repeat(whole(disparity(metres(), 1, 10), "u1")[:, :, None], 3, axis=2)
    assert plate_of(photo, save(tmp_path / "grey.jpg", grey, quality=95)).depth.near_m < 1.1


@pytest.mark.parametrize("names", [("Z",), ("depth.V",), ("R", "G", "B"), ("Y",), ("anything",)])
def test_read_plate_reads_depth_exr_with_any_channel_name(tmp_path, names):
    color = write_file(
        tmp_path / "c.exr", rgb(HEIGHT, WIDTH) | {"Z": np.ones((HEIGHT, WIDTH), "f4")}
    )
    depth = write_file(tmp_path / "d.exr", {name: metres().astype("f4") for name in names})
    plate = plate_of(color, depth)
    np.testing.assert_allclose(plate.depth_m, metres(), rtol=1e-6)
    assert plate.color[..., 0].tobytes() == rgb(HEIGHT, WIDTH)["R"].astype("f4").tobytes()


def test_shot_of_color_and_depth_patterns_exports_matching_frames(tmp_path, capsys):
    for frame in (1001, 1002):
        write_file(tmp_path / f"c.{frame}.exr", rgb(HEIGHT, WIDTH))
        depth = {"Z": (metres() * (frame - 1000)).astype("f4")}
        write_file(tmp_path / f"d.{frame}.exr", depth)
    shot, out = tmp_path / "s.heatlens.json", tmp_path / "o" / "o.####.exr"
    lens = ["--focal-length", 50, "--sensor-width", 36, "--f-stop", 8, "--focus-distance", 2]
    words = ["shot", "new", tmp_path / "c.####.exr", "--depth", tmp_path / "d.####.exr"]
    assert main([str(word) for word in (*words, "-o", shot, *lens)]) == 0
    assert '"depth_source": "d.####.exr"' in shot.read_text()
    export = ["export", shot, "-o", out, "--with-depth", "--quality", "draft"]
    assert "2 frames written" in stderr_of_run(capsys, 0, *export)
    for frame in (1001, 1002):
        written = read_parts(tmp_path / "o" / f"o.{frame}.exr")[0][1]["Z"]
        np.testing.assert_allclose(written, metres() * (frame - 1000), rtol=1e-3)
    assert "2 were finished" in stderr_of_run(capsys, 0, *export)
    write_file(tmp_path / "d.1002.exr", {"Z": metres().astype("f4")})
    assert "1 frame written" in stderr_of_run(capsys, 0, *export)  # its depth is another now
    (tmp_path / "d.1001.exr").unlink()
    assert "d.1001.exr is missing" in stderr_of_run(capsys, 2, *export, "--force")


def test_render_rejects_depth_file_as_output(photo, depth_map, capsys):
    words = ["render", photo, "--depth", depth_map, "-o", depth_map, "--f-stop", 2]
    assert "another name" in stderr_of_run(capsys, 2, *words)


def test_read_plate_of_photo_without_depth_explains_options(photo):
    with pytest.raises(InputError, match=r"no depth:.*--depth FILE.*--depth-side"):
        read_plate(photo)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["jpg", "png", "tif", "npy", "webp"]))
def test_damaged_picture_raises_only_input_error(tmp_path_factory, seed, kind):
    rng, folder = np.random.default_rng(seed), tmp_path_factory.mktemp("damaged")
    good = folder / f"good.{kind}"
    if kind == "npy":
        np.save(good, metres())
    elif kind == "jpg":
        jpeg_with_gdepth(good, 1.0, 10.0, np.full((HEIGHT, WIDTH), 0.5))
    else:
        save(good, colors())
    data = bytearray(good.read_bytes())
    for at in rng.integers(0, len(data), 6):
        data[at] = rng.integers(0, 256)
    bad = folder / f"bad.{kind}"
    bad.write_bytes(data[: rng.integers(1, len(data) + 1)])
    for options in (PlateOptions(), PlateOptions(depth_source=str(bad))):
        try:
            read_plate(bad, options)
        except InputError as error:
            assert str(bad) in str(error)


def test_read_plate_of_heic_without_library_names_extra(tmp_path, monkeypatch):
    (tmp_path / "p.heic").write_bytes(b"nothing")
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"heatlens\[heic\]"):
        read_plate(tmp_path / "p.heic")


def test_pair_picture_with_depth_recognizes_file_names(tmp_path):
    names = [str(tmp_path / n) for n in ("sea.jpg", "sea_depth.png")]
    assert pair_picture_with_depth(names) == pair_picture_with_depth(names[::-1]) == tuple(names)
    for others in (
        ["a.exr", "b.exr"],
        ["a_depth.exr", "b_z.exr"],
        ["a.exr"],
        ["a.glb", "depth.exr"],
    ):
        assert pair_picture_with_depth(others) is None
    for frame in (1, 2):
        (tmp_path / f"z.{frame:04}.exr").write_bytes(b"")
    pair = pair_picture_with_depth([str(tmp_path / "c.0001.exr"), str(tmp_path / "z.0001.exr")])
    assert pair == (str(tmp_path / "c.0001.exr"), str(tmp_path / "z.####.exr"))


def test_color_and_depth_dropped_on_window_open_as_one_plate(ctx, photo, tmp_path):
    depth = save(tmp_path / "photo_depth.png", whole(disparity(metres(), 1, 10), "u2"))
    before = write_file(tmp_path / "b.exr", rgb(HEIGHT, WIDTH) | {"Z": metres().astype("f4")})
    with gui_of(ctx, before) as gui:
        gui.session.files.commands.open_dropped([str(depth), str(photo)])
        gui.until(lambda: gui.session.source.plate.path == photo, "the plate")
        assert gui.session.facts.shot.source == str(photo)
        assert gui.session.facts.shot.plate_options.depth_source == str(depth)
        np.testing.assert_allclose(gui.session.source.plate.depth_m, metres(), rtol=1e-3)


def test_rendered_photo_in_focus_is_unchanged(photo, tmp_path, capsys):
    depth = tmp_path / "d.npy"
    np.save(depth, np.full((HEIGHT, WIDTH), 2.0, np.float32))
    out = tmp_path / "o.png"
    words = ["render", photo, "--depth", depth, "-o", out, "--f-stop", 22, "--focus-distance", 2]
    stderr = stderr_of_run(
        capsys, 0, *words, "--focal-length", 20, "--depth-convention", "distance"
    )
    assert "seen through Un-tone-mapped" in stderr
    np.testing.assert_allclose(np.asarray(Image.open(out)).astype(int), colors(), atol=2)


@pytest.mark.parametrize("name", ["p.png", "p.jpg", "p.tif", "p.heic"])
def test_read_plate_reports_damage_in_one_line(tmp_path, depth_map, name):
    """The files are cut short, or every eighth byte after the head is changed."""
    if name.endswith("heic"):
        pytest.importorskip("pillow_heif").register_heif_opener()
    whole_file = save(tmp_path / name, colors()).read_bytes()
    damaged = bytearray(whole_file)
    damaged[8::8] = bytes(255 - value for value in damaged[8::8])
    for data in (whole_file[: len(whole_file) // 2], bytes(damaged), whole_file[:3]):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=name) as refusal:
            plate_of(tmp_path / name, depth_map, near_m=NEAR_M, far_m=FAR_M)
        assert len(str(refusal.value).splitlines()) == 1
