"""Saving and copying the picture: it is the one that `heatlens render` writes."""

import stat
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from heatlens.core.model.shot.settings import Quality
from heatlens.media.color.view_transform import srgb_transform
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.camera_header import camera_at_header, lens_attributes
from heatlens.media.plate.picture.picture_write import write_png
from support.command_line import render
from support.exr_files import rgb, window, write_file
from support.gui import gui_of

HEIGHT, WIDTH = 40, 64
SEEN = slice(4, HEIGHT - 4), slice(2, WIDTH - 2)  # rows and columns of the display window
CAMERA = lens_attributes(85.0, 2.0, 3.0, 24.9, 18.7)


@pytest.fixture
def plate(tmp_path):
    """Write an anamorphic plate with alpha, overscan and header entries of its own."""
    depth = np.broadcast_to(np.linspace(1, 9, WIDTH, dtype=np.float32), (HEIGHT, WIDTH)).copy()
    alpha = np.linspace(0.5, 1, HEIGHT * WIDTH, dtype=np.float16).reshape(HEIGHT, WIDTH)
    colour = {name: values / 700 for name, values in rgb(HEIGHT, WIDTH, np.float32).items()}
    windows = {"dataWindow": window(-2, -4, WIDTH - 2, HEIGHT - 4)}
    windows["displayWindow"] = window(0, 0, WIDTH - 4, HEIGHT - 8)
    return write_file(
        tmp_path / "plate.exr",
        colour | {"A": alpha, "Z": depth},
        pixelAspectRatio=2.0,
        owner="second unit",
        **windows,
        **CAMERA,
    )


@pytest.fixture
def gui(ctx, plate):
    with gui_of(ctx, plate) as gui:
        yield gui


def save(gui, name):
    """Save through the dialog, typing the name."""
    gui.do("Save picture...")
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    gui.frame(2)
    gui.click(gui.middle("browser name"))
    gui.key(imgui.Key.a, ctrl=True)
    gui.type(name)
    gui.click(gui.middle("browser Save"))


def wait_for_message(gui):
    """Wait until the picture is written; return the message of the window."""
    gui.until(lambda: not gui.session.pictures.saving.is_busy, "the file", 60)
    return gui.session.messages.text


LENSES = [
    ({}, {}),
    ({"f_stop": 1.4, "focus_distance_m": 1.75}, {}),
    ({"squeeze": 1.5, "focus_distance_m": float("inf")}, {"quality": Quality.DRAFT, "proxy": 0.5}),
]


@pytest.mark.parametrize(("lens", "settings"), LENSES)
def test_saved_exr_equals_that_of_the_command_byte_for_byte(
    capsys, gui, plate, tmp_path, lens, settings
):
    session = gui.session
    session.editing.edit_lens(replace(session.facts.lens, **lens))
    session.editing.edit(
        replace(session.facts.shot, defocus=replace(session.facts.shot.defocus, **settings))
    )
    gui.frame(2)
    save(gui, "window.exr")
    assert wait_for_message(gui) == f"Saved {tmp_path / 'window.exr'}."
    shot_lens, defocus = session.facts.lens, session.facts.shot.defocus
    words = ["--f-stop", shot_lens.f_stop, "--focus-distance", shot_lens.focus_distance_m]
    words += [
        "--squeeze",
        shot_lens.squeeze,
        "--quality",
        defocus.effective_quality,
        "--proxy",
        defocus.proxy,
    ]
    render(capsys, plate, tmp_path / "command.exr", *words)
    assert (tmp_path / "window.exr").read_bytes() == (tmp_path / "command.exr").read_bytes()
    ((header, _),) = read_parts(tmp_path / "window.exr")
    camera = camera_at_header([header])
    assert camera.focus_distance_m == pytest.approx(shot_lens.focus_distance_m)
    assert header["owner"] == "second unit"


def expected_png(gui):
    """Compute the PNG on the CPU: transform in the documented order, without the overscan."""
    session = gui.session
    pixels = session.pictures.renderer.pixels(session.facts.shot)[SEEN]
    alpha = pixels[..., 3:]
    light = pixels[..., :3] / alpha
    shown = session.pictures.color.transform.apply_cpu(
        light, session.facts.view.exposure_stops, session.facts.view.gamma
    )
    return np.concatenate([np.clip(shown, 0, 1), np.clip(alpha, 0, 1)], axis=2) * 255


def test_saved_png_has_exposure_gamma_and_view_of_the_window(gui, tmp_path):
    gui.session.pictures.view.state = replace(
        gui.session.facts.view, exposure_stops=0.75, gamma=1.3
    )
    gui.frame(2)
    save(gui, "seen.png")
    assert wait_for_message(gui).startswith("Saved")
    pixels_of_png = np.asarray(Image.open(tmp_path / "seen.png"), np.float32)
    expected = expected_png(gui)
    assert pixels_of_png.shape == expected.shape == (HEIGHT - 8, WIDTH - 4, 4)
    assert np.abs(pixels_of_png - expected).max() <= 0.51
    pixels = gui.session.pictures.renderer.pixels(gui.session.facts.shot)[SEEN]
    plain = srgb_transform().apply_cpu(pixels[..., :3]) * 255
    assert np.abs(pixels_of_png[..., :3] - plain).max() > 5  # the view was not sRGB's plain curve


def test_saved_png_equals_that_of_the_command(gui, capsys, plate, tmp_path):
    gui.settled()
    save(gui, "window.png")
    assert wait_for_message(gui).startswith("Saved")
    lens, defocus = gui.session.facts.lens, gui.session.facts.shot.defocus
    words = ["--f-stop", lens.f_stop, "--focus-distance", lens.focus_distance_m]
    words += [
        "--squeeze",
        lens.squeeze,
        "--quality",
        defocus.effective_quality,
        "--proxy",
        defocus.proxy,
    ]
    render(capsys, plate, tmp_path / "command.png", *words)
    window, command = (
        np.asarray(Image.open(tmp_path / f"{name}.png")) for name in ("window", "command")
    )
    np.testing.assert_array_equal(window, command)


def test_write_png_clips_values_beyond_0_to_1(tmp_path):
    light = np.array([[[-3.0, 0.5, 40.0]]], np.float32)
    write_png(tmp_path / "a.png", light, encode=lambda rgb: rgb)
    assert Image.open(tmp_path / "a.png").getpixel((0, 0)) == (0, 128, 255)


# Waiting for the whole picture


def test_save_waits_for_the_whole_picture_and_says_so(gui, tmp_path):
    session = gui.session
    # Nothing is known: the cheapest picture comes first.
    session.pictures.live.cost.seconds_per_px.clear()
    session.editing.edit_lens(replace(session.facts.lens, f_stop=1.2))
    gui.frame()
    assert session.pictures.live.is_working
    session.pictures.saving.save(tmp_path / "a.exr")
    gui.frame()
    assert (
        "Waiting for the whole picture" in session.messages.text
        and not (tmp_path / "a.exr").exists()
    )
    assert wait_for_message(gui).startswith("Saved") and (tmp_path / "a.exr").exists()


@pytest.mark.parametrize("name", ["gone/away/a.exr", "plate.exr/a.png"])
def test_save_into_a_missing_folder_is_reported(gui, tmp_path, name):
    save(gui, name)
    assert "there is no folder" in wait_for_message(gui)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plate.exr"]


# The clipboard


def write_tool(folder, name, script):
    """Write a stand-in for the clipboard tool of a desktop."""
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


@pytest.fixture
def desktop(tmp_path, monkeypatch):
    """Return the only folder of tools in the PATH, and set a display for them."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    monkeypatch.setenv("DISPLAY", ":99")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    return folder


def test_copied_picture_is_the_png(gui, desktop, tmp_path):
    write_tool(desktop, "xclip", f'cat > {tmp_path}/copied.png; echo "$@" > {tmp_path}/words')
    gui.settled()
    gui.key(imgui.Key.c, ctrl=True)
    assert wait_for_message(gui) == "The picture is on the clipboard."
    assert (tmp_path / "words").read_text() == "-selection clipboard -t image/png -i\n"
    pixels = np.asarray(Image.open(tmp_path / "copied.png"), np.float32)
    assert np.abs(pixels - expected_png(gui)).max() <= 0.51
