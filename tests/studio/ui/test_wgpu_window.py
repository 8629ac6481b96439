"""The window drawn by wgpu is that of OpenGL, and loads none of its libraries."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import GpuError, MissingPackageError, NoWindowError
from heatlens.fronts.commands.main import main
from heatlens.render.gpu.context import Gpu, chosen_gpu
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.wgpu.wgpu_device import headless_device
from heatlens.studio.ui import open_window, theme, window_gpu
from heatlens.studio.ui.window_gpu import imgui_drawing
from support.session_files import room_file
from support.x_server import Screen, Window

SIZE = 320, 200
QUICK = ("--bokeh", "heat", "--quality", "draft", "--proxy", 0.5)


@pytest.fixture(scope="module")
def device() -> Iterator[Device]:
    made = headless_device()
    yield made
    made.release()


def draw_widgets(picture: Texture) -> None:
    """Draw text, controls, a picture upside down, and what a clip cuts."""
    imgui.set_next_window_pos(ImVec2(8.0, 8.0))
    imgui.set_next_window_size(ImVec2(280.0, 170.0))
    imgui.begin("window")
    imgui.text_wrapped("Focus at 1.19 m, f/1.4")
    imgui.button("Set mark here")
    imgui.slider_float("f-stop", 2.8, 1.0, 22.0)
    draw, (x, y) = imgui.get_window_draw_list(), imgui.get_cursor_screen_pos()
    reference = imgui.ImTextureRef(picture.handle)
    draw.add_image(reference, ImVec2(x, y), ImVec2(x + 90, y + 40), ImVec2(0, 1), ImVec2(1, 0))
    draw.push_clip_rect(ImVec2(x + 100, y), ImVec2(x + 130.5, y + 30))
    draw.add_circle_filled(ImVec2(x + 130, y + 20), 25.0, 0x80FF8000)
    draw.pop_clip_rect()
    imgui.end()


def drawn(device: Device, scale: float) -> np.ndarray:
    """Return (H, W, 3) bytes of two frames: the second one uses a font of another size."""
    pixels = round(SIZE[0] * scale), round(SIZE[1] * scale)
    content = np.arange(6 * 4 * 4, dtype=np.uint8).reshape(4, 6, 4) * 2 + 60
    before, context = imgui.get_current_context(), imgui.create_context()
    imgui.set_current_context(context)
    io = imgui.get_io()
    io.set_ini_filename("")
    io.display_size, io.display_framebuffer_scale = SIZE, (scale, scale)
    theme.apply()
    drawing = imgui_drawing(device)
    target = device.framebuffer([device.texture(pixels, 4)])
    picture = device.texture((6, 4), 4, content.tobytes())
    for _ in range(3):
        drawing.begin_frame()
        imgui.new_frame()
        draw_widgets(picture)
        imgui.render()
        target.use()
        target.clear(0.1, 0.2, 0.3, 1.0)
        drawing.draw(target)
        theme.apply(1.3)
    result = np.frombuffer(target.read(components=3), np.uint8).reshape(*pixels[::-1], 3)
    drawing.close()
    imgui.destroy_context(context)
    if before is not None:
        imgui.set_current_context(before)
    device.framebuffer([device.texture((1, 1), 4)]).use()
    return result.astype(int)


@pytest.mark.parametrize("scale", [1.0, 1.5])
def test_imgui_drawn_by_wgpu_is_that_of_opengl(session_context, device, scale):
    by_wgpu, by_opengl = drawn(device, scale), drawn(session_context, scale)
    assert by_opengl.std() > 20
    differing = np.abs(by_wgpu - by_opengl)
    assert differing.max() <= 8
    assert np.mean(differing > 1) <= 1e-3


def loaded_libraries(window: Window) -> str:
    """Return the names of the files that the process of the window has loaded."""
    _, process = window.processes()
    return Path(f"/proc/{process}/maps").read_text()


def test_window_by_wgpu_is_that_of_opengl_and_loads_none_of_its_libraries(tmp_path):
    screen, plate = Screen(), room_file(tmp_path / "room.exr")
    pixels = {}
    try:
        for gpu in ("wgpu", "opengl"):
            window = Window(
                *(screen, tmp_path / gpu, plate, "--gpu", gpu, *QUICK),
                HEATLENS_CACHE_DIR=os.environ["HEATLENS_CACHE_DIR"],
            )
            window.rest()
            pixels[gpu] = np.asarray(screen.picture().convert("RGB")).astype(int)
            maps = loaded_libraries(window)
            window.quit()
            assert window.closed() == (0, "")
            # ImGui's own package brings libraries that lead to OpenGL, and uses none of them
            found = {name for name in ("libEGL", "/libGL.so", "/mgl.", "_dri.so") if name in maps}
            assert bool(found) == (gpu == "opengl"), found
    finally:
        screen.close()
    assert pixels["opengl"].std() > 10
    differing = np.abs(pixels["wgpu"] - pixels["opengl"])
    assert differing.max() <= 4
    assert np.mean(differing > 1) <= 1e-4


def opened_by(monkeypatch, refused: dict[Gpu, Exception]) -> object:
    """Return what opens a window if some libraries refuse."""

    def window_drawn_by(gpu: Gpu, _size: tuple[int, int]) -> Gpu:
        if gpu in refused:
            raise refused[gpu]
        return gpu

    monkeypatch.setattr(open_window, "_window_drawn_by", window_drawn_by)
    monkeypatch.setattr(open_window.glfw, "init", lambda: True)
    monkeypatch.setattr(open_window.glfw, "terminate", lambda: None)
    return open_window.new_window((64, 64))


NO_OPENGL, NO_WGPU = NoWindowError("no OpenGL"), MissingPackageError("no wgpu")


def test_window_is_drawn_by_wgpu_where_there_is_no_opengl(monkeypatch):
    monkeypatch.setenv("HEATLENS_GPU", "auto")
    assert opened_by(monkeypatch, {}) is Gpu.OPENGL
    assert chosen_gpu() is Gpu.AUTO
    assert opened_by(monkeypatch, {Gpu.OPENGL: NO_OPENGL}) is Gpu.WGPU
    assert chosen_gpu() is Gpu.WGPU  # for exports and other processes of the window
    monkeypatch.setenv("HEATLENS_GPU", "auto")
    with pytest.raises(NoWindowError, match="no OpenGL"):
        opened_by(monkeypatch, {Gpu.OPENGL: NO_OPENGL, Gpu.WGPU: NO_WGPU})


@pytest.mark.parametrize("gpu", [Gpu.OPENGL, Gpu.WGPU])
def test_window_is_never_drawn_by_another_library_than_the_chosen_one(monkeypatch, gpu):
    monkeypatch.setenv("HEATLENS_GPU", gpu.value)
    with pytest.raises(GpuError, match="not this one"):
        opened_by(monkeypatch, {gpu: GpuError("not this one")})
    assert window_gpu.window_libraries() == (gpu,)


def test_window_by_wgpu_names_the_missing_part(monkeypatch):
    monkeypatch.setitem(sys.modules, "heatlens.studio.ui.wgpu_window", None)
    with pytest.raises(MissingPackageError, match=r"heatlens\[wgpu\]"):
        window_gpu.attach(Gpu.WGPU, None)


def test_view_refuses_a_number_of_a_device_that_opengl_cannot_choose(monkeypatch, capsys):
    monkeypatch.setenv("HEATLENS_GPU", "auto")
    monkeypatch.setenv("GLCONTEXT_DEVICE_INDEX", "0")  # the command changes it
    assert main(["view", "--device", "1"]) == 2
    assert "--device needs --gpu wgpu" in capsys.readouterr().err
