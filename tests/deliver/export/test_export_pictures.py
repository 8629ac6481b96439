"""Test exported PNG, JPEG and TIFF: the view transform of the linear EXR, and the burn-in."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.timecode import parse_timecode
from heatlens.deliver.export.burn_in import (
    DEFAULT_TEMPLATE,
    _font,
    burn_in_text,
    check_template,
    draw_burn_in,
)
from heatlens.fronts.commands.main import main
from heatlens.media.color.color_config import load_color_config
from heatlens.media.color.view_transform import srgb_transform, view_transform
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.picture.picture_write import quantize
from support.cube_config import cube_config
from support.exports import (
    FRAMES,
    HEIGHT,
    WIDTH,
    export_shot,
    exr,
    files_in,
    names_of,
    refused_export_message,
    shot_of,
    write_plate,
    write_plates,
)
from support.exr_files import window, write_file
from support.plates import coc_plate_of, plate_of, room
from support.written_pictures import pixels

LUMA = np.array([0.2126, 0.7152, 0.0722])  # JPEG halves the chroma
PLAIN = ("--view", "sRGB curve")


def exr_colors(path) -> np.ndarray:
    """Return the colours (H, W, 3) of an EXR."""
    channels = exr(path)[1]
    return np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float32)


def write_exr_plate(path, color: np.ndarray) -> None:
    """Write a plate with one depth, which is in focus everywhere."""
    channels = {name: color[..., i] for i, name in enumerate("RGB")}
    write_file(path, channels | {"Z": np.full(color.shape[:2], 2, np.float32)})


def codes(display: np.ndarray) -> np.ndarray:
    """Return display values 0..1 as codes 0..255, not rounded."""
    return np.clip(display, 0, 1) * 255


# The view


@pytest.mark.parametrize("exposure", [0.0, -1.5])
def test_export_with_srgb_curve_view_matches_transform(capsys, shot_file, tmp_path, exposure):
    words = ("--frames", "1003")
    look = (f"--exposure={exposure}", *PLAIN)
    message = export_shot(capsys, shot_file, tmp_path / "n.png", *words, *look)
    export_shot(capsys, shot_file, tmp_path / "n.exr", *words, "--float")
    expected = srgb_transform().apply_cpu(exr_colors(tmp_path / "n.exr"), exposure)
    assert np.abs(pixels(tmp_path / "n.png") - codes(expected)).max() < 0.5 + 1e-2
    assert "seen through sRGB curve on sRGB" in message


def test_export_without_view_uses_default_view_of_config(capsys, shot_file, tmp_path):
    """The default is the first view of the config in use, as in the window."""
    words = ("--frames", "1003")
    message = export_shot(capsys, shot_file, tmp_path / "n.png", *words)
    export_shot(capsys, shot_file, tmp_path / "n.exr", *words, "--float")
    config = load_color_config(None)
    names = (config.default_display, config.default_view, config.default_input_space)
    expected = view_transform(config, *names).apply_cpu(exr_colors(tmp_path / "n.exr"))
    assert np.abs(pixels(tmp_path / "n.png") - codes(expected)).max() < 1
    assert f"seen through {config.default_view} on {config.default_display}" in message


@pytest.mark.parametrize("look", [(), PLAIN, ("--exposure=1.5", "--gamma=1.3")])
def test_render_and_export_write_identical_pixels(capsys, tmp_path, look):
    """Both use the view shader of the window, so every pixel of many colors is equal."""
    color = np.random.default_rng(3).uniform(0, 2, (400, 600, 3)).astype(np.float32)
    plate = tmp_path / "p.1001.exr"
    write_exr_plate(plate, color)
    lens = ("--focal-length=50", "--f-stop=2", "--focus-distance=2", "--sensor-width=36")
    assert main(["render", str(plate), "-o", str(tmp_path / "r.png"), *lens, *look]) == 0
    capsys.readouterr()
    export_shot(capsys, plate, tmp_path / "e.####.png", *lens, *look, "--frames=1001")
    np.testing.assert_array_equal(pixels(tmp_path / "r.png"), pixels(tmp_path / "e.1001.png"))


def test_export_with_view_option_matches_that_view(capsys, shot_file, tmp_path):
    config = load_color_config(None)
    display = config.displays()[0]
    view = config.views(display)[1]
    words = ("--frames", "1003", "--float")
    export_shot(capsys, shot_file, tmp_path / "n.exr", *words)
    export_shot(capsys, shot_file, tmp_path / "n.png", "--frames", "1003", "--view", view)
    transform = view_transform(config, display, view, config.default_input_space)
    expected = transform.apply_cpu(exr_colors(tmp_path / "n.exr"))
    assert np.abs(pixels(tmp_path / "n.png") - codes(expected)).max() < 1


def test_export_with_own_ocio_config_uses_its_first_view(capsys, shot_file, tmp_path):
    path = cube_config(tmp_path).source
    export_shot(capsys, shot_file, tmp_path / "n.exr", "--frames", "1003", "--float")
    export_shot(capsys, shot_file, tmp_path / "n.png", "--frames", "1003", "--ocio", path)
    config = load_color_config(path)
    names = (config.default_display, config.views(config.default_display)[0])
    transform = view_transform(config, *names, config.default_input_space)
    expected = transform.apply_cpu(exr_colors(tmp_path / "n.exr"))
    assert np.abs(pixels(tmp_path / "n.png") - codes(expected)).max() < 1


def test_export_with_other_view_renders_frames_again(capsys, shot_file, tmp_path):
    out = tmp_path / "n.####.png"
    export_shot(capsys, shot_file, out)
    assert "6 frames written" in export_shot(capsys, shot_file, out, "--view", "Raw")
    assert "0 frames written" in export_shot(capsys, shot_file, out, "--view", "Raw")


@pytest.mark.parametrize("option", ["--view", "--display"])
def test_export_rejects_unknown_view_and_lists_known_ones(capsys, shot_file, tmp_path, option):
    message = refused_export_message(capsys, shot_file, tmp_path / "n.####.png", option, "Nix")
    assert "'Nix'" in message and ("Raw" if option == "--view" else "sRGB") in message


def test_jpeg_export_is_close_to_png_export(capsys, shot_file, tmp_path):
    for suffix in (".png", ".jpg"):
        export_shot(
            capsys, shot_file, tmp_path / suffix[1:] / f"n.####{suffix}", "--exposure", "-1"
        )
    assert list(files_in(tmp_path / "jpg")) == names_of(".jpg")
    for frame in FRAMES:
        png, jpg = (pixels(tmp_path / s / f"n.{frame}.{s}") for s in ("png", "jpg"))
        assert jpg.shape == png.shape and np.abs((jpg - png) @ LUMA).mean() < 2


# The display window


def test_export_crops_or_pads_pictures_to_display_window(capsys, tmp_path):
    """Overscan is cropped, pixels that were not rendered are black, all frames have one size."""
    folder = tmp_path / "plates"
    display = {"displayWindow": window(0, 0, WIDTH, HEIGHT)}
    source = write_plates(folder, **display)
    over = (WIDTH + 8, HEIGHT + 4)
    windows = {"dataWindow": window(-4, -2, WIDTH + 4, HEIGHT + 2)}
    write_plate(folder / "plate.1002.exr", size=over, **windows, **display)
    part = {"dataWindow": window(6, 3, 22, 15)}
    write_plate(folder / "plate.1003.exr", size=(16, 12), **part, **display)
    write_shot(tmp_path / "s.heatlens.json", shot_of(source))
    for suffix, look in ((".png", PLAIN), (".exr", ())):
        export_shot(capsys, tmp_path / "s.heatlens.json", tmp_path / f"n.####{suffix}", *look)
    pictures = {frame: pixels(tmp_path / f"n.{frame}.png") for frame in FRAMES}
    assert {picture.shape for picture in pictures.values()} == {(HEIGHT, WIDTH, 3)}
    transform = srgb_transform()
    whole = codes(transform.apply_cpu(exr_colors(tmp_path / "n.1002.exr")))
    assert np.abs(pictures[1002] - whole[2:-2, 4:-4]).max() < 1
    inner = codes(transform.apply_cpu(exr_colors(tmp_path / "n.1003.exr")))
    assert np.abs(pictures[1003][3:15, 6:22] - inner).max() < 1
    pictures[1003][3:15, 6:22] = 0
    assert not pictures[1003].any()


# Burnt in


def test_burn_in_changes_only_lower_edge_of_picture(capsys, tmp_path):
    folder = tmp_path / "plates"
    folder.mkdir()
    for frame in (1001, 1002):
        write_plate(folder / f"plate.{frame}.exr", size=(192, 108))
    shot = shot_of(str(folder / "plate.####.exr"), (1001, 1002))
    write_shot(tmp_path / "s.heatlens.json", shot)
    export_shot(capsys, tmp_path / "s.heatlens.json", tmp_path / "a.####.png")
    export_shot(capsys, tmp_path / "s.heatlens.json", tmp_path / "b.####.png", "--burn-in")
    clean, burnt = (pixels(tmp_path / f"{name}.1001.png") for name in "ab")
    rows = np.flatnonzero((clean != burnt).any(axis=(1, 2)))
    assert rows.min() >= 0.9 * 108 and rows.max() == 107
    assert burnt[rows].max() > 150 and burnt[rows].mean() < clean[rows].mean()
    other_frame = pixels(tmp_path / "b.1002.png")
    assert (burnt[rows] != other_frame[rows]).any()


@pytest.mark.parametrize(
    ("lens", "unit", "expected"),
    [
        (Lens(50.0, 1.4, 2.24, 36.0), "m", "F 1001   2.24 m   f/1.4"),
        (Lens(50.0, 2.0, 1.905, 36.0), "ft", "F 1001   6'3\"   f/2"),
        (Lens(50.0, 2.8284, float("inf"), 36.0), "m", "F 1001   inf   f/2.83"),
    ],
)
def test_burn_in_text_holds_frame_focus_and_f_stop(lens, unit, expected):
    assert burn_in_text(DEFAULT_TEMPLATE, 1001, lens, plate_of(*room()), unit) == expected


def test_burn_in_text_holds_timecode_and_fills_own_template():
    facts = Lens(50.0, 2.0, 2.24, 36.0), plate_of(*room()), "m", parse_timecode("10:00:00:05")
    assert burn_in_text(DEFAULT_TEMPLATE, 1001, *facts) == "F 1001   10:00:00:05   2.24 m   f/2"
    assert burn_in_text(DEFAULT_TEMPLATE, 1001, *facts, "pull").endswith("f/2   pull")
    template = "{shot} {timecode}    at {focus}, f/{f_stop}  ({frame})"
    assert burn_in_text(template, 7, *facts, "a") == "a 10:00:00:05    at 2.24 m, f/2  (7)"


def test_check_template_rejects_unknown_field_and_lists_known():
    with pytest.raises(InputError, match=r"no \{focsu\}; it has .*\{focus\}"):
        check_template("{frame} {focsu}")


@pytest.mark.parametrize("height", [20, 270, 1080])
def test_burn_in_font_is_monospaced(height):
    """Equal widths make spaces visible and keep numbers in place from frame to frame."""
    font = _font(height / 24)
    widths = {font.getlength(character) for character in " 0123456789.:m/FfWil"}
    assert len(widths) == 1 and widths.pop() > 0.4 * font.size
    assert font.getlength("2.622 m") == font.getlength("2.622") + 2 * font.getlength("m")


def test_burn_in_depends_on_shot_name_and_template(capsys, tmp_path):
    write_plate(tmp_path / "plate.1001.exr", size=(192, 108))
    shot = shot_of(str(tmp_path / "plate.####.exr"), (1001,))
    for name, words in (("a", ()), ("b", ()), ("a", ("--burn-in-text", "{frame}"))):
        write_shot(tmp_path / f"{name}.heatlens.json", shot)
        out = tmp_path / f"{name}{len(words)}.####.png"
        export_shot(capsys, tmp_path / f"{name}.heatlens.json", out, "--burn-in", *words)
    a, b, short = (pixels(tmp_path / f"{name}.1001.png") for name in ("a0", "b0", "a2"))
    assert (a != b).any() and (a != short).any()


def test_burn_in_text_of_coc_plate_omits_lens():
    plate = coc_plate_of(room()[0], np.ones((54, 96), np.float32))
    assert burn_in_text(DEFAULT_TEMPLATE, 1001, Lens(50.0, 2.0, 2.0, 36.0), plate, "m") == "F 1001"


@pytest.mark.parametrize("size", [(1, 1), (16, 10), (160, 400), (400, 40), (640, 360)])
def test_burn_in_text_fits_into_pictures_of_any_size(size):
    """The text stays left of the right edge and inside the lower strip; values stay in 0..1."""
    width, height = size
    picture = np.full((height, width, 3), 0.5, np.float32)
    burnt = draw_burn_in(picture, "F 1001   2.24 m   f/1.4   pull")
    assert burnt.shape == picture.shape and (picture == 0.5).all()
    assert burnt.min() >= 0 and burnt.max() <= 1 and (burnt != 0.5).any()
    if min(size) >= 40:
        strip = burnt[(burnt != 0.5).any(axis=(1, 2))]
        assert len(strip) < 0.4 * height
        assert (strip[:, -2:] == strip.min()).all() and strip.max() > 0.5


def test_quantised_rounds_and_clamps_values():
    display = np.array([[[-1.0, 0.0, 0.4999 / 255], [0.5001 / 255, 1.0, 7.0], [np.nan, 0.5, 1]]])
    assert quantize(display.astype(np.float32), np.uint8)[0].tolist() == [
        [0, 0, 0],
        [1, 255, 255],
        [0, 128, 255],
    ]
    assert quantize(display.astype(np.float32), np.uint16)[0, 1].tolist() == [129, 65535, 65535]


# TIFF


def test_tiff_export_has_pixels_of_png_export(capsys, shot_file, tmp_path):
    for suffix in (".png", ".tif"):
        export_shot(capsys, shot_file, tmp_path / f"n{suffix}", "--frames", "1003", *PLAIN)
    np.testing.assert_array_equal(pixels(tmp_path / "n.tif"), pixels(tmp_path / "n.png"))
