"""A window that listens to a renderer: its frames appear and are refined in the window."""

import argparse
import re
import socket
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui
from tevclient import Ipc

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands import view
from heatlens.fronts.commands.command_parser import add_command
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.source.kinds import NO_FILES
from heatlens.render.source.stream_source import StreamSource
from heatlens.studio.settings.start import Start
from heatlens.studio.ui.picture import notices
from support.gui import Gui
from support.plates import room
from support.session_files import LENS, QUICK
from support.tev_peers import CHANNELS

WIDTH, HEIGHT = 48, 32
LENS_OPTIONS = {
    "focal_length_mm": LENS.focal_length_mm,
    "f_stop": LENS.f_stop,
    "focus_distance_m": LENS.focus_distance_m,
    "sensor_width_mm": LENS.sensor_width_mm,
}


@contextmanager
def listening_window(ctx, options=PlateOptions(), lens=LENS_OPTIONS):  # noqa: B008
    """Return a window that waits for a renderer, with an ImGui of its own."""
    before, context = imgui.get_current_context(), imgui.create_context()
    imgui.set_current_context(context)
    stream = StreamSource("127.0.0.1", 0)
    gui = Gui(ctx, Start(stream.text, options, lens, QUICK, stream=stream))
    try:
        gui.frame(3)
        yield gui
    finally:
        gui.close()
        imgui.destroy_context(context)
        if before is not None:
            imgui.set_current_context(before)


def address(gui):
    host, port = gui.session.source.stream.address.rsplit(":", 1)
    return host, int(port)


def frame_of_room(width=WIDTH, height=HEIGHT):
    """Return colours and distances of the room, (H, W, 4)."""
    color, depth = room(width, height)
    return np.ascontiguousarray(np.dstack([color[..., :3], depth]).astype(np.float32))


def send_frame(gui, values, name="beauty", channels=CHANNELS, creates=True):
    """Send a frame with the real client, and draw until it is on the GPU."""
    before = gui.session.source.picture.version
    with Ipc(*address(gui)) as client:
        if creates:
            client.create_image(name, values.shape[1], values.shape[0], list(channels))
        client.update_image(name, values, list(channels))
    gui.until(lambda: gui.session.source.picture.version > before, "the frame")


def assert_shows(gui, values):
    """Assert that the window shows the renderer's picture of a frame with these values."""

    def has_frame():
        plate = gui.session.source.plate
        return plate is not None and np.array_equal(plate.color[..., :3], values[..., :3])

    gui.until(has_frame, "the frame as it was sent")
    gui.settled()
    renderer = FrameRenderer(gui.ctx)
    renderer.load(gui.session.source.plate)
    shown = download(gui.session.pictures.live.output.texture)
    np.testing.assert_array_equal(shown, renderer.pixels(gui.session.facts.shot))
    np.testing.assert_array_equal(gui.session.source.plate.depth_m, values[..., 3])


def test_streamed_frame_appears_and_updates_keep_the_lens_and_marks(ctx):
    values = frame_of_room()
    with listening_window(ctx) as gui:
        stream = gui.session.source.stream
        assert (
            stream.status_text == f"Listening on {stream.address} ..."
            and gui.session.source.is_waiting
        )
        send_frame(gui, values)
        assert_shows(gui, values)
        assert gui.session.facts.shot.source == stream.text == f"tev://{stream.address}"
        sent_lens = replace(LENS, model=LensModel.RENDERER)  # as everything that a renderer sends
        assert gui.session.facts.lens == sent_lens and not gui.session.source.is_waiting
        gui.session.editing.edit_lens(replace(gui.session.facts.lens, f_stop=4.0))
        gui.session.time.marks.set_point((3, 5))
        shot = gui.session.facts.shot
        refined = values * np.float32([0.5, 0.5, 2, 1])
        send_frame(gui, refined, creates=False)
        assert_shows(gui, refined)
        another = frame_of_room(30, 40)
        send_frame(gui, another, "next frame")
        assert_shows(gui, another)
        assert gui.session.facts.shot == shot and shot.marks


def test_image_without_depth_is_reported_over_the_picture(ctx, monkeypatch):
    values, notices_drawn = frame_of_room(), []
    monkeypatch.setattr(notices.imgui, "text_wrapped", notices_drawn.append)
    monkeypatch.setattr(notices, "_draw_wrapped", lambda text, *_: notices_drawn.append(text))
    with listening_window(ctx) as gui:
        with Ipc(*address(gui)) as client:
            client.create_image("flat", WIDTH, HEIGHT, list("RGB"))
        gui.until(
            lambda: any("flat has no depth channel" in it for it in notices_drawn), "a sentence"
        )
        send_frame(gui, values)
        assert_shows(gui, values)
        del notices_drawn[:]
        gui.frame(2)
        other_words = {it for it in notices_drawn if not it.startswith("Renderer left at")}
        assert other_words <= {"lens from the file"}  # which the Lens panel says
        with Ipc(*address(gui)) as client:
            client.create_image("later", WIDTH, HEIGHT, list("RGB"))
        gui.until(
            lambda: any("later has no depth channel" in it for it in notices_drawn), "a notice"
        )
        assert re.fullmatch("[0-2][0-9]:[0-5][0-9]", gui.session.source.stream.left_at)
        gui.key(imgui.Key.escape)
        del notices_drawn[:]
        gui.frame(2)
        assert any(it.startswith("Renderer left at ") for it in notices_drawn)
        with Ipc(*address(gui)):
            gui.until(lambda: not gui.session.source.stream.left_at, "the renderer again")
        assert gui.session.source.plate.path.name == "beauty"


def test_streamed_picture_is_saved_but_file_actions_are_refused(ctx, tmp_path):
    values = frame_of_room()
    with listening_window(ctx) as gui:
        send_frame(gui, values)
        assert_shows(gui, values)
        gui.session.pictures.saving.save(tmp_path / "a.exr")
        gui.until(lambda: gui.session.messages.text.startswith("Saved"), "the file")
        saved = read_parts(tmp_path / "a.exr")[0][1]
        shown = download(gui.session.pictures.live.output.texture)
        for i, name in enumerate("RGB"):
            np.testing.assert_allclose(saved[name], shown[..., i], rtol=2e-3)  # of half floats
        for name in ("Reload", "Export...", "Save shot"):
            gui.session.messages.clear()
            gui.do(name)
            assert gui.session.messages.text == NO_FILES, name


def parse_view(*words):
    parser = argparse.ArgumentParser()
    add_command(parser.add_subparsers(), "view", "", view)
    return parser.parse_args(["view", *words])


def test_listen_option_is_checked_before_a_window_opens(monkeypatch):
    monkeypatch.setattr(
        "heatlens.studio.ui.window.run_window", lambda start: pytest.fail("a window")
    )
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        with pytest.raises(InputError, match=f"Cannot listen on 127.0.0.1:{port}"):
            view.run(parse_view("--listen", port))
    with pytest.raises(InputError, match="not an address to listen on"):
        view.run(parse_view("--listen", "here"))
    with pytest.raises(InputError, match=r"leave plate\.exr out"):
        view.run(parse_view("plate.exr", "--listen"))


def test_listen_port_is_free_after_the_window_closes(monkeypatch):
    addresses = []

    def window(start):
        addresses.append(start.stream.address)
        with pytest.raises(InputError):
            StreamSource("127.0.0.1", int(start.stream.address.rsplit(":", 1)[1]))

    monkeypatch.setattr("heatlens.studio.ui.window.run_window", window)
    assert view.run(parse_view("--listen", "127.0.0.1:0")) == 0
    host, port = addresses[0].rsplit(":", 1)
    StreamSource(host, int(port)).close()
    assert parse_view("--listen").listen == "14158"
