"""Test that a plate's primaries have the same effect in `render`, `export` and the window."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.fronts.commands.main import main
from heatlens.media.color.color_config import PLAIN_OCIO_VIEW, load_color_config
from heatlens.media.color.view_transform import srgb_transform, to_rec709
from heatlens.media.plate.header.primaries import AP1, KNOWN, REC709, XYZ
from heatlens.media.plate.picture.display import decode_srgb, encode_srgb
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.gpu.textures import download, new_texture, upload
from heatlens.studio.settings.preferences import Preferences
from support.command_line import picture
from support.exr_files import write_file
from support.gui import gui_of

QUICK = DefocusSettings(bokeh=Bokeh.HEAT, quality=Quality.DRAFT, layers=1)
LENS = ("--focal-length", "50", "--sensor-width", "36", "--f-stop", "22", "--focus-distance", "2")
PLAIN = ("--view", "sRGB curve")
ORANGE = np.array([0.5, 0.25, 0.1], np.float32)  # linear Rec.709, inside of all the gamuts
NO_TRIANGLE = (0.6, 0.3, 0.4, 0.3, 0.2, 0.3, 0.31, 0.33)
known = pytest.mark.parametrize("primaries", KNOWN, ids=lambda primaries: primaries.name)


def write_orange_plate(path, primaries, **attributes):
    """Write a plate of one orange in these primaries, which the header names by default."""
    values = np.linalg.inv(to_rec709(primaries)) @ ORANGE
    size = (12, 16)
    channels = {name: np.full(size, v, np.float32) for name, v in zip("RGB", values, strict=True)}
    channels["Z"] = np.full(size, 2.0, np.float32)
    header = attributes or {"chromaticities": primaries.chromaticities}
    return write_file(path, channels, **header)


def assert_orange(path):
    shown = np.asarray(Image.open(path).convert("RGB"), float)
    assert np.abs(shown - 255 * encode_srgb(ORANGE)).max() <= 1.0


@known
def test_render_converts_color_space_for_png_and_keeps_it_in_exr(capsys, tmp_path, primaries):
    plate = write_orange_plate(tmp_path / "plate.exr", primaries)
    for name, view_options in (("out.png", PLAIN), ("out.exr", ())):
        words = ["-o", str(tmp_path / name), *LENS, "--quality", "draft", *view_options]
        assert main(["render", str(plate), *words]) == 0
    assert_orange(tmp_path / "out.png")
    header, light = picture(tmp_path / "out.exr")
    assert header["chromaticities"] == pytest.approx(primaries.chromaticities, abs=1e-6)
    assert np.allclose(to_rec709(primaries) @ light[6, 8], ORANGE, atol=2e-3)
    assert "primaries" not in capsys.readouterr().err


@known
@pytest.mark.parametrize("through", ["plain", "ocio"])
def test_export_converts_primaries_of_plate(capsys, tmp_path, primaries, through):
    write_orange_plate(tmp_path / "plate.1001.exr", primaries)
    out = tmp_path / "out" / "####.png"
    words = ["export", str(tmp_path / "plate.####.exr"), "-o", str(out), *LENS, *PLAIN]
    if through == "ocio":
        words += ["--display", "sRGB - Display", "--view", "Un-tone-mapped"]
    assert main([*words, "--quality", "draft"]) == 0
    assert_orange(tmp_path / "out" / "1001.png")
    assert "plate is read as" not in capsys.readouterr().err


def test_export_keeps_primaries_of_plate_in_exr(tmp_path):
    header_values = {"colorInteropID": AP1.interop_id, "chromaticities": AP1.chromaticities}
    write_orange_plate(tmp_path / "plate.1001.exr", AP1, **header_values)
    words = ["export", str(tmp_path / "plate.####.exr"), "-o", str(tmp_path / "out" / "####.exr")]
    assert main([*words, *LENS, "--quality", "draft"]) == 0
    header, _ = picture(tmp_path / "out" / "1001.exr")
    assert header["colorInteropID"] == AP1.interop_id
    assert header["chromaticities"] == pytest.approx(AP1.chromaticities, abs=1e-6)


def test_export_uses_input_space_option_over_header(tmp_path):
    header_values = {"chromaticities": REC709.chromaticities}  # which is not true
    write_orange_plate(tmp_path / "plate.1001.exr", AP1, **header_values)
    words = ["export", str(tmp_path / "plate.####.exr"), "-o", str(tmp_path / "out" / "####.png")]
    words += ["--view", "Un-tone-mapped", "--input-space", "ACEScg", "--quality", "draft"]
    assert main([*words, *LENS]) == 0
    assert_orange(tmp_path / "out" / "1001.png")


def test_render_and_export_warn_once_of_impossible_primaries(capsys, tmp_path):
    plate = write_orange_plate(tmp_path / "plate.1001.exr", REC709, chromaticities=NO_TRIANGLE)
    words = [str(plate), *LENS, "--quality", "draft", "-o"]
    for command, out in (("render", "a.png"), ("export", "b.png")):
        assert main([command, *words, str(tmp_path / out), *PLAIN]) == 0
        assert capsys.readouterr().err.count("until another input space is chosen") == 1
        assert_orange(tmp_path / out)
    assert main(["render", *words, str(tmp_path / "c.exr")]) == 0
    assert "input space" not in capsys.readouterr().err


def test_export_renders_again_when_header_primaries_change(capsys, tmp_path):
    plate, out = tmp_path / "plate.1001.exr", tmp_path / "out" / "####.png"
    words = ["export", str(tmp_path / "plate.####.exr"), "-o", str(out), *LENS, *PLAIN]
    write_orange_plate(plate, AP1, chromaticities=REC709.chromaticities)
    assert main([*words, "--quality", "draft"]) == 0
    write_orange_plate(plate, AP1)
    assert main([*words, "--quality", "draft"]) == 0
    assert_orange(tmp_path / "out" / "1001.png")


@pytest.mark.parametrize("primaries", [AP1, XYZ], ids=lambda primaries: primaries.name)
def test_display_pass_converts_input_space_as_cpu_does(ctx, primaries):
    light = np.random.default_rng(3).uniform(-0.2, 2.0, (5, 7, 4)).astype(np.float32)
    transform = srgb_transform(primaries.name)
    screen, source = DisplayPass(ctx), new_texture(ctx, (7, 5), 4)
    out = new_texture(ctx, (7, 5), 4)
    upload(source, light)
    screen.set_transform(transform)
    screen.run(source, out)
    drawn = download(out)[..., :3]
    for resource in (screen, source, out):
        resource.release()
    assert np.allclose(drawn, transform.apply_cpu(light[..., :3]), atol=2e-3)


def test_window_uses_header_input_space_until_user_selects_one(ctx, tmp_path):
    plate = write_orange_plate(tmp_path / "acescg.exr", AP1)
    other = write_orange_plate(tmp_path / "rec709.exr", REC709)
    with gui_of(ctx, plate, defocus=QUICK) as gui:
        session = gui.session
        session.pictures.view.state = replace(
            session.facts.view, display="sRGB - Display", view="Un-tone-mapped"
        )
        gui.frame(2)
        assert session.pictures.color.transform.input_space == "ACEScg"
        light = np.linalg.inv(to_rec709(AP1)).astype(np.float32) @ ORANGE
        shown = session.pictures.color.transform.apply_cpu(light.reshape(1, 1, 3))
        assert np.allclose(shown, encode_srgb(ORANGE), atol=1e-3)
        gui.open(other)
        assert session.pictures.color.transform.input_space == "Linear Rec.709 (sRGB)"
        session.pictures.view.state = replace(session.facts.view, input_space="Linear Rec.2020")
        gui.open(plate)
        assert session.pictures.color.transform.input_space == "Linear Rec.2020"
        imgui.set_window_focus("Display")
        gui.frame(2)
        gui.click(gui.middle("input"))
        gui.click(gui.middle("input: auto: ACEScg"))
        gui.frame(2)
        assert (session.facts.view.input_space, session.pictures.color.transform.input_space) == (
            "",
            "ACEScg",
        )


def test_window_warns_of_unknown_primaries(ctx, tmp_path):
    plate = write_orange_plate(tmp_path / "odd.exr", REC709, chromaticities=NO_TRIANGLE)
    with gui_of(ctx, plate, defocus=QUICK) as gui:
        assert gui.session.messages.text.count("until another input space is chosen") == 1
        assert gui.session.pictures.color.transform.input_space == "Linear Rec.709 (sRGB)"


def test_window_without_opencolorio_uses_header_primaries(ctx, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "PyOpenColorIO", None)
    with gui_of(ctx, write_orange_plate(tmp_path / "acescg.exr", AP1), defocus=QUICK) as gui:
        transform = gui.session.pictures.color.transform
        assert (transform.view, transform.input_space) == ("sRGB curve", "ACEScg")


def test_decode_srgb_matches_opencolorio_srgb_texture():
    """The curve of 8-bit pictures is that of the config's own space, for every value they have.

    OpenColorIO approximates powers: a hundredth of the step from one code to the next.
    """
    config = load_color_config(None).config
    codes = np.arange(256, dtype=np.float32) / np.float32(255)
    light = np.repeat(codes[:, None], 3, axis=1)
    turned = config.getProcessor("sRGB - Texture", "Linear Rec.709 (sRGB)")
    turned.getDefaultCPUProcessor().applyRGB(light)
    np.testing.assert_allclose(decode_srgb(codes), light[:, 0], atol=3e-5)


def test_window_and_render_show_photo_through_same_plain_view(ctx, tmp_path, capsys):
    """The next plate is shown through the config's first view again; a chosen view stays."""
    plate = write_orange_plate(tmp_path / "plate.exr", REC709)
    photo = tmp_path / "photo.png"
    Image.fromarray(np.full((24, 36, 3), 120, np.uint8)).save(photo)
    depth = np.linspace(1, 3, 24 * 36, dtype=np.float32).reshape(24, 36)
    np.save(tmp_path / "depth.npy", depth)
    options = PlateOptions(depth_source=str(tmp_path / "depth.npy"), depth_convention="distance")
    first = load_color_config(None).default_view
    words = ("render", str(photo), "--depth", str(tmp_path / "depth.npy"), *LENS)
    assert main([*words, "-o", str(tmp_path / "o.png"), "--depth-convention", "distance"]) == 0
    assert f"seen through {PLAIN_OCIO_VIEW}" in capsys.readouterr().err
    assert main(["info", str(photo)]) == 0
    assert f"seen through    {PLAIN_OCIO_VIEW}" in capsys.readouterr().out
    preferences = Preferences()
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        session = gui.session
        assert session.facts.view.view == first
        gui.open(photo, options)
        assert session.facts.view.view == PLAIN_OCIO_VIEW
        session.save_preferences()
        assert preferences.values.view == ""  # nobody chose it
        gui.open(plate)
        assert session.facts.view.view == first
        session.pictures.view.state = replace(session.facts.view, view="Raw")
        gui.open(photo, options)
        assert session.facts.view.view == "Raw"
        session.save_preferences()
        assert preferences.values.view == "Raw"
