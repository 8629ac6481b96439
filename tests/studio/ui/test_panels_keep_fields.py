"""Drawing a panel changes no field of the value that it edits.

The tests go through the fields of the dataclasses, so a field that is added later is covered.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.value_bins import bin_values, depth_histogram
from heatlens.core.model.view.overlays import OVERLAYS
from heatlens.core.model.view.view import Against, ViewState
from heatlens.media.plate.read import read_plate
from heatlens.render.display.color_choice import ColorChoice
from heatlens.studio.settings.export_settings import ExportSettings
from heatlens.studio.ui.panels.display_panel import display_panel
from heatlens.studio.ui.panels.export_panel import export_panel
from heatlens.studio.ui.panels.lens_panel import LensFacts, lens_panel
from heatlens.studio.ui.panels.opening_panel import opening_panel
from heatlens.studio.ui.panels.rendering_panel import blur_rows
from heatlens.studio.ui.panels.source_panel import PlateFacts, plate_panel
from heatlens.studio.ui.panels.source_rows import matte_rows
from support.gui import Gui, gui_of
from support.other_values import with_all_fields_other, with_other_fields
from support.scene_window import reset_scene
from support.session_files import LENS, QUICK, room_file, write_scene

FRAMES = 3
TALL = (1280, 1600)  # every control of a panel is in sight
Draw = Callable[[Any], Any]


@pytest.fixture
def screen() -> Iterator[None]:
    """Make a separate ImGui context that draws nothing."""
    before, context = imgui.get_current_context(), imgui.create_context()
    imgui.set_current_context(context)
    io = imgui.get_io()
    io.set_ini_filename("")
    io.display_size = TALL
    io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
    yield
    imgui.destroy_context(context)
    if before is not None:
        imgui.set_current_context(before)


def value_after_drawing(draw: Draw, value: Any) -> Any:
    """Draw a panel for `FRAMES` frames, each with the value of the last; return the value."""
    for _ in range(FRAMES):
        imgui.new_frame()
        imgui.set_next_window_size(TALL)
        imgui.begin("panel")
        value = draw(value)
        imgui.end()
        imgui.render()
    return value


def fail_on_report(sentence: str) -> None:
    """Fail if a panel reports a problem, since all values are allowed."""
    raise AssertionError(sentence)


def assert_fields_kept(draw: Draw, value: Any, names: dict[str, Any] | None = None) -> None:
    """Assert for each field that a value with another content of it is unchanged by drawing."""
    checked_names = set()
    for name, changed in with_other_fields(value, names):
        assert getattr(changed, name) != getattr(value, name)
        assert value_after_drawing(draw, changed) == changed, name
        checked_names.add(name)
    assert checked_names == {field.name for field in fields(value)}


@pytest.fixture
def facts(tmp_path: Path) -> PlateFacts:
    plate = read_plate(room_file(tmp_path / "room.exr"))
    return PlateFacts(
        plate, depth_histogram(bin_values(np.float32(1.0) / plate.depth_m)), None, "m", "", LENS
    )


@pytest.mark.parametrize("has_many_views", [False, True])
@pytest.mark.parametrize("settings", [DefocusSettings(), QUICK])
def test_blur_rows_keep_every_field(screen, has_many_views, settings):
    assert_fields_kept(lambda value: blur_rows(value, has_many_views), settings)


def test_lens_and_opening_panels_keep_every_field(screen, facts):
    lens_facts = LensFacts(facts.histogram, unit="m", sources={})
    assert_fields_kept(lambda value: lens_panel(value, lens_facts, fail_on_report), LENS)
    assert_fields_kept(lambda value: opening_panel(value, fail_on_report, lambda: None), LENS)
    without_distances = LensFacts(histogram=None, unit="ft", sources={})
    assert_fields_kept(lambda value: lens_panel(value, without_distances, fail_on_report), LENS)


def test_plate_panel_keeps_every_option(screen, facts):
    assert_fields_kept(
        lambda value: plate_panel(value, facts, fail_on_report, lambda: None), PlateOptions()
    )


def test_mattes_of_the_blur_keep_every_option(screen):
    assert_fields_kept(
        lambda value: matte_rows(value, fail_on_report, fail_on_report), PlateOptions()
    )


def test_display_panel_keeps_every_field(screen):
    color = ColorChoice(None, fail_on_report)
    display = next(d for d in color.displays() if len(color.views(d)) > 1)
    view = color.limit_to_config(replace(ViewState(), display=display))
    names = {
        "display": next(d for d in color.displays() if d != display),
        "view": color.views(display)[1],
        "input_space": color.input_spaces()[0],
        "against": Against.REFERENCE,
        "overlay": OVERLAYS[0].name,
    }
    assert_fields_kept(
        lambda value: display_panel(
            value, color, "reference.exr", has_many_views=True, notify=print
        ),
        view,
        names,
    )


@pytest.mark.parametrize("kind", ["EXR (linear)", "PNG (as displayed)"])
def test_export_panel_keeps_every_setting(screen, kind):
    settings = ExportSettings("/folder", "name", kind)
    names = {"kind": "H.264 movie", "camera_kind": "Nuke", "quality": "draft"}
    assert_fields_kept(lambda value: export_panel(value, None, None)[0], settings, names)


def test_panel_keeps_a_field_that_is_added_later(screen):
    @dataclass(frozen=True, slots=True)
    class Later(DefocusSettings):
        later: int = 0

    assert_fields_kept(lambda value: blur_rows(value, has_many_views=False), Later())


# All panels of the window, with what they are handed there


def draw_each_panel(gui: Gui) -> None:
    """Bring every panel to the front in turn, some frames each."""
    gui.ui.panels = dict.fromkeys(gui.ui.panels, True)
    gui.frame(2)
    for name in gui.ui.panels:
        imgui.set_window_focus(name)
        gui.frame(FRAMES)


def test_drawing_all_panels_changes_no_field_of_the_shot(gui: Gui):
    shot = gui.session.facts.shot
    lens = with_all_fields_other(shot.lens)
    blur = with_all_fields_other(shot.defocus, {"method": Method.HEAT, "proxy": 0.75})
    gui.session.editing.edit(replace(shot, lens=lens, defocus=blur))
    shot_before = gui.session.facts.shot
    draw_each_panel(gui)
    assert gui.session.facts.shot == shot_before
    assert shot_before.lens == lens and shot_before.defocus == blur


def test_drawing_all_panels_changes_no_field_of_the_view(gui: Gui):
    view = gui.session.facts.view
    # Names of the config, and what is B.
    excluded_fields = ("display", "view", "input_space", "against")
    gui.session.pictures.view.state = with_all_fields_other(
        view,
        {"center_px": (40.0, 30.0), "overlay": OVERLAYS[0].name},
        except_fields=excluded_fields,
    )
    view_before = gui.session.facts.view
    draw_each_panel(gui)
    assert gui.session.facts.view == view_before


@pytest.fixture
def scene_gui(ctx, tmp_path: Path) -> Iterator[Gui]:
    with gui_of(ctx, write_scene(tmp_path / "scene.gltf"), defocus=QUICK) as gui:
        yield reset_scene(gui)


def test_drawing_all_panels_changes_no_field_of_a_scene_framing(scene_gui: Gui):
    framing = scene_gui.session.facts.shot.framing
    assert isinstance(framing, Framing)
    for name, other in with_other_fields(framing, {"camera": "side"}):
        scene_gui.session.editing.begin(replace(scene_gui.session.facts.shot, framing=other))
        draw_each_panel(scene_gui)
        assert scene_gui.session.facts.shot.framing == other, name
