"""A scene in the window: camera moves by mouse, camera keys, objects, and methods for scenes."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.orbit import pivot_of
from heatlens.core.model.view.view import Against, Compare
from heatlens.media.scene.scene_read import read_scene
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import download
from heatlens.studio.ui.status_bar import mouse_words
from support.gltf_files import GltfWriter
from support.gui import Gui, gui_of
from support.patience import PATIENCE_S
from support.scene_window import draw_small, picture_center, reset_scene, wait_for_whole_picture
from support.session_files import QUICK

LEFT, RIGHT = 0, 1


@pytest.fixture
def scene_gui(ctx: Device, window: Gui) -> Gui:
    return reset_scene(window)


def position_beside_the_middle(gui: Gui) -> tuple[float, float]:
    x, y = picture_center(gui)
    return x + 60, y + 20


def pose(gui: Gui) -> Pose:
    return gui.session.scenes.pose


def test_all_six_tabs_fit_side_by_side(scene_gui):
    bar = imgui.internal.find_window_by_name("Source").dock_node.tab_bar
    assert bar.tabs.size() == 6 and bar.width_all_tabs <= bar.bar_rect.get_width()


def test_scene_opens_with_the_picture_of_its_first_camera(scene_gui):
    session = scene_gui.session
    assert session.scenes.framing.camera == "main" and session.messages.text == ""
    plate = session.source.plate
    assert plate.color.shape == (54, 96, 4) and np.ptp(plate.color) > 0.1
    assert plate.depth_m[27, 48] == pytest.approx(3.0, rel=1e-5)


def test_right_drag_orbits_about_the_focus_and_can_be_undone(scene_gui):
    before, focus = pose(scene_gui), scene_gui.session.facts.lens.focus_distance_m
    pivot = pivot_of(before, focus)
    scene_gui.drag(picture_center(scene_gui), position_beside_the_middle(scene_gui), RIGHT)
    after = pose(scene_gui)
    assert np.linalg.norm(np.subtract(after.position_m, before.position_m)) > 0.1
    np.testing.assert_allclose(pivot_of(after, focus), pivot, atol=1e-6)
    assert after.position_m[0] < before.position_m[0]  # the scene follows the hand
    scene_gui.rest()
    scene_gui.session.editing.undo()
    scene_gui.frame(2)
    assert pose(scene_gui) == before and scene_gui.session.scenes.framing.track is None


def test_right_click_without_a_drag_keeps_the_camera(scene_gui):
    shot = scene_gui.session.facts.shot
    scene_gui.click(picture_center(scene_gui), RIGHT)
    assert scene_gui.session.facts.shot == shot


def test_small_preview_of_a_moving_scene_keeps_its_size_on_screen(scene_gui, monkeypatch):
    session = scene_gui.session
    large = replace(session.scenes.framing, width_px=960, height_px=540)
    session.editing.do(replace(session.facts.shot, framing=large))
    session.pictures.view.state = replace(session.facts.view, zoom=1.0)
    wait_for_whole_picture(scene_gui)
    shape, before = session.facts.shape, session.pictures.view.geometry
    draw_small(scene_gui, monkeypatch)
    scene_gui.press(picture_center(scene_gui), RIGHT)
    x, y = picture_center(scene_gui)
    scene_gui.move((x + 20.0, y))
    scene_gui.frame()
    assert session.source.plate.display_window.width < 960  # it is drawn small ...
    assert (session.facts.shape, session.pictures.view.geometry) == (
        shape,
        before,
    )  # and seen large
    assert (
        session.source.feed.plate_px(session.facts.shot, (959, 539))[0]
        < session.source.plate.display_window.width
    )
    scene_gui.release(RIGHT)


def test_ctrl_right_drag_trucks_the_camera(scene_gui):
    before = pose(scene_gui)
    scene_gui.hold(imgui.Key.mod_ctrl)
    scene_gui.drag(picture_center(scene_gui), position_beside_the_middle(scene_gui), RIGHT)
    scene_gui.hold(imgui.Key.mod_ctrl, down=False)
    after = pose(scene_gui)
    np.testing.assert_allclose(after.turn, before.turn, atol=1e-9)
    movement = before.turn.T @ np.subtract(after.position_m, before.position_m)
    assert movement[0] < 0 and movement[1] > 0 and movement[2] == pytest.approx(0.0, abs=1e-9)


def test_ctrl_wheel_dollies_the_camera_without_zooming(scene_gui):
    before, zoom = pose(scene_gui), scene_gui.session.pictures.view.zoom
    scene_gui.hold(imgui.Key.mod_ctrl)
    scene_gui.wheel(picture_center(scene_gui), 1)
    scene_gui.hold(imgui.Key.mod_ctrl, down=False)
    movement = before.turn.T @ np.subtract(pose(scene_gui).position_m, before.position_m)
    np.testing.assert_allclose(movement[:2], 0, atol=1e-9)
    assert movement[2] < -0.05
    wait_for_whole_picture(scene_gui)
    assert scene_gui.session.pictures.view.zoom == zoom


def test_status_bar_explains_the_right_button_in_a_scene(scene_gui):
    text = scene_gui.screen.status.words(None)  # the pointer is beside the picture
    assert "Right drag orbits" in text and "Ctrl+wheel" in text and "F1 shows the keys" in text
    assert "Right drag" not in mouse_words(has_camera=False)


def test_left_click_focuses_at_the_depth_of_the_scene(scene_gui):
    scene_gui.click(picture_center(scene_gui), LEFT)
    assert scene_gui.session.facts.lens.focus_distance_m == pytest.approx(3.0, rel=1e-5)


def test_camera_moves_between_its_keys(scene_gui):
    session, scenes = scene_gui.session, scene_gui.session.scenes
    first, last = session.facts.shot.played_frames.first, session.facts.shot.played_frames.last
    scenes.set_key()
    start = pose(scene_gui)
    session.time.timeline.go_to(last)
    scene_gui.frame(2)
    scenes.set_key()
    scene_gui.drag(picture_center(scene_gui), position_beside_the_middle(scene_gui), RIGHT)
    end = pose(scene_gui)
    assert scenes.key_frames == (first, last)
    session.time.timeline.go_to((first + last) // 2)
    scene_gui.frame(2)
    between = np.array(pose(scene_gui).position_m)
    assert np.linalg.norm(between - start.position_m) > 0.01
    assert np.linalg.norm(between - end.position_m) > 0.01
    session.time.timeline.go_to(last)
    scene_gui.frame(2)
    imgui.set_window_focus("Source")
    scene_gui.frame(2)  # the panel tells of the keys
    scene_gui.click(scene_gui.middle("delete camera key"))
    assert scenes.key_frames == (first,) and pose(scene_gui) == start


def test_frame_selected_centers_the_object_and_reports_unknown_ones(scene_gui):
    scenes = scene_gui.session.scenes
    scenes.look_through("side")
    scenes.selected = "near"
    scenes.frame_selected()
    camera_point = pose(scene_gui).world_to_camera @ (0, 0, 0, 1)
    np.testing.assert_allclose(camera_point[:2], 0, atol=1e-6)
    before, scenes.selected = pose(scene_gui), "of another scene"
    scenes.frame_selected()
    assert pose(scene_gui) == before and "of another scene" in scene_gui.session.messages.text


@pytest.mark.parametrize("method", [m for m in Method if m.needs_scene])
def test_a_and_b_of_a_scene_equal_a_separate_render(scene_gui, method, renderer: FrameRenderer):
    session = scene_gui.session
    scene_defocus = replace(QUICK, method=method, views=8)
    renderer.load_scene(read_scene(Path(session.facts.shot.source)))
    expected = renderer.pixels(
        replace(session.facts.shot, defocus=scene_defocus), session.editing.frame
    )
    session.editing.edit(replace(session.facts.shot, defocus=scene_defocus))
    wait_for_whole_picture(scene_gui)
    np.testing.assert_array_equal(download(session.pictures.live.output.texture), expected)
    session.editing.edit(replace(session.facts.shot, defocus=replace(QUICK, views=8)))
    against = {"compare": Compare.WIPE, "against": Against.METHOD, "b_method": method}
    session.pictures.view.state = replace(session.facts.view, **against)
    scene_gui.frame()
    wait_for_whole_picture(scene_gui)
    shown = session.pictures.sides.picture_of_b(session.facts.view)
    np.testing.assert_array_equal(download(shown.texture), expected)


def test_damaged_scene_is_reported_and_the_open_scene_stays(scene_gui, tmp_path):
    bad = tmp_path / "bad.glb"
    bad.write_bytes(b"glTF" + b"\0" * 60)
    session = scene_gui.session
    shot, plate = session.facts.shot, session.source.plate
    session.files.commands.open(str(bad))
    scene_gui.until(lambda: session.messages.text, "a sentence")
    assert "bad.glb" in session.messages.text
    assert session.facts.shot == shot and session.source.plate is plate


def test_grid_shows_previews_of_scene_looks_before_whole_pictures(scene_gui):
    """With a slow method, both looks appear as previews first, then each as a whole picture."""
    gui, session = scene_gui, scene_gui.session
    start_lens = session.facts.lens
    raytraced = replace(session.facts.shot.defocus, method=Method.RAYTRACED, views=4)
    session.editing.do(replace(session.facts.shot, defocus=raytraced))
    for f_stop in (2.0, 4.0):
        session.editing.edit_lens(replace(start_lens, f_stop=f_stop))
        gui.rest()
        session.pictures.looks.keep()
    session.editing.edit_lens(replace(start_lens, f_stop=22.0))
    gui.rest()
    wait_for_whole_picture(gui)
    session.pictures.looks.toggle_grid()
    widths, words, end = [], {}, time.monotonic() + PATIENCE_S
    gui.frame()
    while (
        any(session.pictures.sides.is_unfinished(name) for name in "AB") and time.monotonic() < end
    ):
        session.work()  # makes one picture at most
        gui.frame()
        tiles = gui.screen.picture.pictures.tiles[:2]
        widths.append(tuple(0 if it.texture is None else it.texture.width for it in tiles))
        words |= {width: it.words for it, width in zip(tiles, widths[-1], strict=True)}
    order = [(0, 0), (24, 0), (24, 24), (96, 24), (96, 96)]
    assert [pair for pair in order if pair in widths] == list(dict.fromkeys(widths))
    assert {(24, 24), (96, 24), (96, 96)} <= set(widths)
    assert "preview, rendering" in words[24]
    gui.frame(2)
    assert not any("rendering" in tile.words for tile in gui.screen.picture.pictures.tiles)
    session.pictures.looks.toggle_grid()
    wait_for_whole_picture(gui)


def test_scene_panel_with_many_objects_keeps_its_buttons_visible(ctx, tmp_path):
    writer = GltfWriter()
    mesh = writer.mesh()
    for number in range(40):
        writer.node(name=f"object {number}", mesh=mesh, translation=[0.1 * number, 0.0, -3.0])
    with gui_of(ctx, writer.write(tmp_path / "many.glb"), defocus=QUICK) as gui:
        imgui.set_window_focus("Source")
        gui.frame(4)
        panel = imgui.internal.find_window_by_name("Source")
        assert panel.scroll_max.y == 0.0
        assert gui.rect("mark object")[3] <= panel.inner_rect.max.y
        _, y0, _, y1 = gui.rect("object object 0")
        assert (gui.rect("mark object")[1] - y0) / (y1 - y0) > 5  # lines that are seen
