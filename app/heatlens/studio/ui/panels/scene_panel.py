"""Draw what the Source panel shows of a scene: cameras, clips, camera keys, size, objects."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.messages import report_errors
from heatlens.core.base.outside_text import printable
from heatlens.media.scene.placing import lacks_placing
from heatlens.media.scene.scene_bounds import object_names
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.ui import rects, texts, widgets

_OWN_CAMERA = "moved by hand"
_CAMERA_TIP = (
    "The camera of the view, with its lens. In the picture, drag with the right button to orbit "
    "what is in focus, with Ctrl to move sideways; Ctrl and the wheel move nearer."
)
_CLIP_TIP = (
    "The animation to play. The shot's frames become those in which something moves. The file is "
    "read again."
)
_LINES_MOST = 10  # largest height of the list of objects
_UP_TIP = "The up axis, which the file does not define."
_UNIT_TIP = "The length of one unit, which the file does not define. The focus scales with it."
_UNITS = {1.0: "m", 0.01: "cm", 0.001: "mm", 0.3048: "ft", 0.0254: "in"}
_SIZES = ((640, 360), (1280, 720), (1920, 1080))


def scene_panel(control: TimeControl) -> None:
    """Draw the rows in the current window; a scene must be open."""
    scenes, scene = control.scenes, control.scenes.scene
    assert scene is not None
    _camera_row(control)
    _clip_row(control)
    _key_row(control)
    _size_row(control)
    if lacks_placing(scene):
        _axis_and_unit_rows(control)
    imgui.separator_text("Objects")
    names = object_names(scene)
    if imgui.begin_list_box("##objects", ImVec2(-1, _list_height(len(names)))):
        for index, name in enumerate(names):
            is_clicked = _object_row(printable(name), index, name == scenes.selected)
            rects.note(f"object {name}")
            if is_clicked:
                scenes.selected = name
        imgui.end_list_box()
    with widgets.disabled(scenes.selected is None):
        if widgets.button("Frame it", "frame object"):
            scenes.frame_selected()
        imgui.same_line()
        if widgets.button("Focus on it", "focus on object") and scenes.selected is not None:
            with report_errors(control.notify):
                scenes.focus_on(scenes.selected)
        imgui.same_line()
        if widgets.button("Mark it", "mark object") and scenes.selected is not None:
            with report_errors(control.notify):
                scenes.set_mark(scenes.selected)
    imgui.text_disabled(f"{scene.triangle_count:,} triangles, {len(scene.instances)} instances")


def _list_height(count: int) -> float:
    """Return the height of the list in screen units: all objects, or `_LINES_MOST` of them."""
    line, padding = imgui.get_text_line_height_with_spacing(), imgui.get_style().frame_padding.y
    return float(min(count, _LINES_MOST) * line + padding)


def _object_row(name: str, index: int, is_selected: bool) -> bool:
    """Draw the name of an object, cut to fit; return True if it was clicked."""
    width = imgui.get_content_region_avail().x
    fitted_name = texts.fit_text(name, width)
    is_clicked, _ = imgui.selectable(f"{fitted_name}##{index}", is_selected)
    if fitted_name != name and imgui.is_item_hovered():
        imgui.set_tooltip(name)
    return bool(is_clicked)


def _camera_row(control: TimeControl) -> None:
    """Draw the choice of the camera; look through the chosen one."""
    scenes, scene, framing = control.scenes, control.scenes.scene, control.scenes.framing
    assert scene is not None
    names = [camera.name for camera in scene.cameras]
    own_name = [_OWN_CAMERA] if framing.track is not None or not names else []
    current = _OWN_CAMERA if own_name else framing.camera or names[0]
    chosen_name = widgets.choice("camera", current, [*own_name, *names], _CAMERA_TIP)
    if chosen_name not in (current, _OWN_CAMERA):
        scenes.look_through(chosen_name)


def _clip_row(control: TimeControl) -> None:
    """Draw the choice of the animation clip, if there are several."""
    clips = control.scenes.clips
    if not clips.names:
        return
    chosen_name = widgets.choice("clip", clips.current_name, list(clips.names), _CLIP_TIP)
    if chosen_name != clips.current_name:
        clips.choose(chosen_name)


def _key_row(control: TimeControl) -> None:
    """Draw the buttons for camera keys, and the frames of the keys."""
    scenes, keys = control.scenes, control.scenes.key_frames
    if widgets.button("Set camera key", "set camera key"):
        scenes.set_key()
    imgui.same_line()
    with widgets.disabled(control.editing.frame not in keys or len(keys) < 2):
        if widgets.button("Delete key", "delete camera key"):
            scenes.delete_key()
    if len(keys) > 1:
        texts.gray_text("keys at " + ", ".join(f"{frame:g}" for frame in keys))


def _size_row(control: TimeControl) -> None:
    """Draw the choice of the size of the picture."""
    framing = control.scenes.framing
    sizes = {size: f"{size[0]}x{size[1]}" for size in (*_SIZES, framing.size)}
    width, height = widgets.pick("size", framing.size, sizes, "Pixels of the picture")
    if (width, height) != framing.size:
        new_framing = replace(framing, width_px=width, height_px=height)
        control.editing.do(replace(control.editing.shot, framing=new_framing))


def _axis_and_unit_rows(control: TimeControl) -> None:
    """Draw the choice of up axis and unit, for files that do not define them."""
    framing = control.scenes.framing
    up_axis, unit_m = widgets.pick_one("up axis", framing.up_axis, _UP_TIP), framing.meters_per_unit
    words = _UNITS | {unit_m: _UNITS.get(unit_m, f"{unit_m:g} m")}
    control.scenes.set_axis_and_unit(up_axis, widgets.pick("unit", unit_m, words, _UNIT_TIP))
