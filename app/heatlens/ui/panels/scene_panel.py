"""The scene: its cameras, its objects, the camera's keys and the size of the picture."""

from dataclasses import replace
from typing import TYPE_CHECKING

from imgui_bundle import ImVec2, imgui

from heatlens.errors import HeatlensError
from heatlens.scene.scene_bounds import object_names
from heatlens.ui import widgets

if TYPE_CHECKING:
    from collections.abc import Callable

    from heatlens.ui.app import App

_OWN = "moved by hand"
_CAMERA_TIP = (
    "Which camera is looked through. In the picture the right button turns it round what is in "
    "focus, with Ctrl it goes aside, and Ctrl with the wheel goes nearer."
)
_LIST_EM = 9.0
_SIZES = {"640x360": (640, 360), "1280x720": (1280, 720), "1920x1080": (1920, 1080)}


def scene_panel(app: "App") -> None:
    """Draw it in the current window; there is a scene."""
    scene = app.scenes.scene
    assert scene is not None
    _camera(app)
    _keys(app)
    _size(app)
    imgui.separator_text("Objects")
    size = ImVec2(-1, _LIST_EM * imgui.get_font_size())
    if imgui.begin_list_box("##objects", size):
        for name in object_names(scene):
            clicked, _ = imgui.selectable(name, name == app.scenes.selected)
            widgets.note(f"object {name}")
            if clicked:
                app.scenes.selected = name
        imgui.end_list_box()
    with widgets.disabled(app.scenes.selected is None):
        if imgui.button("Frame it"):
            app.scenes.frame_selected()
        widgets.note("frame object")
        imgui.same_line()
        if imgui.button("Focus on it") and app.scenes.selected is not None:
            _try(app, lambda: app.scenes.focus_on(app.scenes.selected or ""))
        widgets.note("focus on object")
        imgui.same_line()
        if imgui.button("Mark it") and app.scenes.selected is not None:
            _try(app, lambda: app.scenes.mark(app.scenes.selected or ""))
        widgets.note("mark object")
    imgui.text_disabled(f"{scene.triangle_count:,} triangles, {len(scene.instances)} instances")


def _camera(app: "App") -> None:
    scene, framing = app.scenes.scene, app.scenes.framing
    assert scene is not None
    names = [camera.name for camera in scene.cameras]
    own = [_OWN] if framing.track is not None or not names else []
    now = _OWN if own else framing.camera or names[0]
    chosen = widgets.choice("camera", now, [*own, *names], _CAMERA_TIP)
    if chosen not in (now, _OWN):
        app.scenes.look_through(chosen)


def _keys(app: "App") -> None:
    keys = app.scenes.key_frames
    if imgui.button("Set camera key"):
        app.scenes.set_key()
    widgets.note("set camera key")
    imgui.same_line()
    with widgets.disabled(app.editing.frame not in keys or len(keys) < 2):
        if imgui.button("Delete key"):
            app.scenes.delete_key()
        widgets.note("delete camera key")
    if len(keys) > 1:
        imgui.push_style_color(
            imgui.Col_.text, imgui.get_style_color_vec4(imgui.Col_.text_disabled)
        )
        imgui.text_wrapped("keys at " + ", ".join(f"{frame:g}" for frame in keys))
        imgui.pop_style_color()


def _size(app: "App") -> None:
    framing = app.scenes.framing
    now = f"{framing.width_px}x{framing.height_px}"
    sizes = _SIZES | {now: framing.size}
    chosen = widgets.choice("size", now, list(sizes), "Pixels of the picture")
    if chosen != now:
        width, height = sizes[chosen]
        changed = replace(framing, width_px=width, height_px=height)
        app.editing.do(replace(app.shot, framing=changed))


def _try(app: "App", act: "Callable[[], None]") -> None:
    try:
        act()
    except HeatlensError as error:
        app.say(str(error))
