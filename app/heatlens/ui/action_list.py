"""Build the list of all actions: the content of each menu, with its shortcuts."""

from collections.abc import Callable
from functools import partial

from imgui_bundle import imgui

from heatlens.model.guides import MATTES
from heatlens.model.settings import Method
from heatlens.model.view import Against, Compare, Overlay
from heatlens.scene.scene_name import DEMO
from heatlens.session.session import Session
from heatlens.session.settings.preferences import Theme
from heatlens.ui.actions import CTRL, SHIFT, Action
from heatlens.ui.panels.lens_panel import barred_methods
from heatlens.ui.state import PANELS, UiState
from heatlens.ui.timeline.actions import key_actions, play_actions

_K = imgui.Key
_DIGITS = (_K._1, _K._2, _K._3, _K._4, _K._5, _K._6, _K._7, _K._8, _K._9)
MENUS = ("File", "Edit", "Lens", "Play", "Animate", "View", "Compare", "Window", "Help")
GROUPS = frozenset(  # the first action of each group; its menu draws a separator above it
    {
        *("Open shot...", "Save picture...", "Quit"),
        *("Focus at infinity", "Keep this look", "Next quality"),
        *("Next key", "Set in point", "Clear rendered frames"),
        *("Set mark here", "Auto key", "Interpolate hold after key", "Show curve"),
        *("Fit", "Pixel grid", "Brighter", "Metres or feet", "Near, in focus, far"),
        *("Matte 2.39", "Safe areas", "Frame selected"),
        *("More gain", "B is the reference", "Compare with pinhole"),
        *("Lens", "Reset layout"),
    }
)


def actions(session: Session, ui: UiState) -> tuple[Action, ...]:
    """Return all actions, in the order of the menus."""
    return (
        *(*_file(session, ui), *_edit(session), *_lens(session)),
        *(*play_actions(session, ui.timeline.open_frames), *key_actions(session, ui.open_pull)),
        *(*_view(session, ui), *_overlays(session), *_scene(session)),
        *(*_compare(session), *_window(ui)),
    )


def _file(session: Session, ui: UiState) -> list[Action]:
    ask, files = ui.dialogs.ask, session.files.commands
    return [
        Action("Open...", "File", partial(ask, "open"), _K.o | CTRL),
        Action("Open reference...", "File", partial(ask, "reference"), _K.o | CTRL | SHIFT),
        Action("Add a picture behind...", "File", partial(ask, "behind")),
        Action("Open the demo", "File", partial(files.open, DEMO)),
        Action("Start screen...", "File", session.files.start_choices.show),
        Action("Open shot...", "File", partial(ask, "shot")),
        Action("Save shot", "File", partial(_save_shot, session, ui), _K.s | CTRL),
        Action("Save shot as...", "File", partial(ask, "save shot"), _K.s | CTRL | SHIFT),
        Action("Reload", "File", files.reload, _K.r | CTRL),
        Action("Save picture...", "File", partial(ask, "save"), _K.e | CTRL | SHIFT),
        Action("Import camera...", "File", partial(ask, "camera")),
        Action("Export...", "File", partial(_show_export, session, ui), _K.e | CTRL),
        Action("Pull sheet...", "File", partial(ask, "sheet")),
        Action("Copy picture", "File", session.pictures.saving.copy, _K.c | CTRL),
        Action("Quit", "File", ui.quit, _K.q | CTRL),
    ]


def _save_shot(session: Session, ui: UiState) -> None:
    """Save the shot to its file, or ask for a file name where it has none."""
    if not session.files.documents.save():
        ui.dialogs.ask("save shot")


def _show_export(session: Session, ui: UiState) -> None:
    """Bring the Export panel to the front."""
    if session.files.exports.why_not:
        session.messages.say(session.files.exports.why_not)
    ui.panels["Export"] = True
    imgui.set_window_focus("Export")


def _scene(session: Session) -> list[Action]:
    def barred() -> str:
        is_there = session.facts.has_camera
        return "" if is_there else "Only a scene has a camera and objects, and none is open."

    scenes = session.scenes
    return [
        Action("Set camera key", "Animate", scenes.set_key, barred=barred),
        Action("Frame selected", "View", scenes.frame_selected, barred=barred),
    ]


def _edit(session: Session) -> list[Action]:
    editing = session.editing

    def undo_words() -> str:
        return editing.history.undo_words

    def redo_words() -> str:
        return editing.history.redo_words

    return [
        Action(
            "Undo", "Edit", editing.undo, _K.z | CTRL, repeats=True,
            barred=lambda: "" if undo_words() else "There is nothing to undo.",
            label=lambda: f"Undo {undo_words()}".strip(),
        ),
        Action(
            "Redo", "Edit", editing.redo, _K.z | CTRL | SHIFT, repeats=True,
            barred=lambda: "" if redo_words() else "There is nothing to redo.",
            label=lambda: f"Redo {redo_words()}".strip(),
        ),
    ]  # fmt: skip


def _lens(session: Session) -> list[Action]:
    lens, left, right = session.lens.commands, _K.left_bracket, _K.right_bracket
    return [
        Action("Focus nearer", "Lens", partial(lens.nudge_focus, 1), left, repeats=True),
        Action("Focus farther", "Lens", partial(lens.nudge_focus, -1), right, repeats=True),
        Action("Open 1/3 stop", "Lens", partial(lens.step_f_stop, -1), left | SHIFT, repeats=True),
        Action("Close 1/3 stop", "Lens", partial(lens.step_f_stop, 1), right | SHIFT, repeats=True),
        Action("Focus at infinity", "Lens", lens.focus_at_infinity),
        Action("Reset lens", "Lens", lens.reset),
        Action("Keep this look", "Lens", session.pictures.looks.keep, _K.l | SHIFT),
        Action("Back to the lens before", "Lens", session.pictures.looks.back, _K.backspace),
        *(
            Action(
                f"Look {index + 1}", "Lens", partial(session.pictures.looks.go, index), key | CTRL
            )
            for index, key in enumerate(_DIGITS)
        ),
        Action("Next quality", "Lens", lens.next_quality, _K.q),
        Action("Next bokeh", "Lens", lens.next_bokeh, _K.b),
    ]


def _view(session: Session, ui: UiState) -> list[Action]:
    view, scale, theme = session.pictures.commands, ui.scale, ui.theme
    return [
        Action(
            "Depth of field", "View", partial(view.toggle, "depth_of_field"), _K.d,
            is_on=lambda: session.facts.view.depth_of_field,
        ),
        Action("Fit", "View", view.fit, _K.f),
        Action("1:1", "View", view.one_to_one, _K._1),
        Action("Zoom in", "View", partial(view.zoom, 2.0), _K.equal, repeats=True),
        Action("Zoom out", "View", partial(view.zoom, 0.5), _K.minus, repeats=True),
        Action(
            "Pixel grid", "View", partial(view.toggle, "pixel_grid"), _K.g,
            is_on=lambda: session.facts.view.pixel_grid,
        ),
        Action(
            "Values in pixels", "View", partial(view.toggle, "pixel_values"), _K.g | SHIFT,
            is_on=lambda: session.facts.view.pixel_values,
        ),
        Action(
            "Ruler", "View", view.toggle_ruler, _K.n,
            is_on=lambda: view.ruler.is_on, barred=lambda: view.ruler.why_not(),
        ),
        Action("Brighter", "View", partial(view.expose, 1), _K.up_arrow | CTRL, repeats=True),
        Action("Darker", "View", partial(view.expose, -1), _K.down_arrow | CTRL, repeats=True),
        Action("Reset exposure and gamma", "View", view.reset_exposure_and_gamma, _K._0 | CTRL),
        Action("Metres or feet", "View", view.toggle_unit, _K.u),
        Action("Larger interface", "View", partial(scale.step, 1), _K.equal | CTRL),
        Action("Smaller interface", "View", partial(scale.step, -1), _K.minus | CTRL),
        Action("Interface as large as usual", "View", scale.reset),
        Action("Light theme", "View", theme.toggle, is_on=lambda: theme.now is Theme.LIGHT),
    ]  # fmt: skip


def _overlays(session: Session) -> list[Action]:
    keyed = (
        (Overlay.ZONES, "Near, in focus, far", _K.z),
        (Overlay.FOCUS_PLANE, "Plane in focus", _K.p),
        (Overlay.COC, "Circle of confusion", _K.c),
        (Overlay.DEPTH, "Depth", _K.v),
        (Overlay.LAYERS, "Layers", _K.l),
    )

    def toggle(overlay: Overlay, name: str, key: int) -> Action:
        return Action(
            name, "View", partial(session.pictures.commands.toggle_overlay, overlay), key,
            is_on=lambda: session.facts.view.overlay is overlay,
        )  # fmt: skip

    peaking = Action(
        "Focus peaking", "View", partial(session.pictures.commands.toggle, "is_peaking"),
        _K.p | SHIFT, is_on=lambda: session.facts.view.is_peaking,
    )  # fmt: skip
    zones, *others = (toggle(*row) for row in keyed)
    return [zones, peaking, *others, *_guides(session)]


def _guides(session: Session) -> list[Action]:
    view = session.pictures.commands

    def is_matte(aspect: float | None) -> Callable[[], bool]:
        return lambda: session.facts.view.guides.aspect == aspect

    def is_drawn(field: str) -> Callable[[], bool]:
        return lambda: bool(getattr(session.facts.view.guides, field))

    lines = (("safe_areas", "Safe areas"), ("thirds", "Thirds"), ("centre", "Centre cross"))
    return [
        *(
            Action(
                f"Matte {name}", "View", partial(view.toggle_matte, aspect), is_on=is_matte(aspect)
            )
            for name, aspect in MATTES.items()
        ),
        *(
            Action(name, "View", partial(view.toggle_guide, field), is_on=is_drawn(field))
            for field, name in lines
        ),
    ]


def _compare(session: Session) -> list[Action]:
    view = session.pictures.commands

    def toggle(compare: Compare, name: str, key: imgui.Key) -> Action:
        return Action(
            name, "Compare", partial(view.toggle_compare, compare), key,
            is_on=lambda: session.facts.view.compare is compare,
        )  # fmt: skip

    def compare_with(method: Method | None) -> Action:
        return Action(
            f"Compare with {method or 'pinhole'}", "Compare", partial(view.compare_with, method),
            barred=lambda: barred_methods(session.facts.has_many_views).get(str(method), ""),
        )  # fmt: skip

    return [
        toggle(Compare.WIPE, "Wipe", _K.w),
        toggle(Compare.FLIP, "Flip to B", _K.x),
        toggle(Compare.DIFFERENCE, "Difference", _K.e),
        Action(
            "Grid of looks", "Compare", session.pictures.looks.toggle_grid, _K.w | SHIFT,
            is_on=lambda: session.facts.view.compare is Compare.GRID,
        ),
        Action("More gain", "Compare", partial(view.step_gain, 1), _K.period),
        Action("Less gain", "Compare", partial(view.step_gain, -1), _K.comma),
        Action(
            "B is the reference", "Compare", view.swap_b, _K.r,
            is_on=lambda: session.facts.view.against is Against.REFERENCE,
        ),
        *(compare_with(method) for method in (None, *Method)),
    ]  # fmt: skip


def _window(ui: UiState) -> list[Action]:
    def panel(name: str) -> Action:
        key = _K.t if name == "Speed" else 0
        toggle = partial(ui.toggle_panel, name)
        return Action(name, "Window", toggle, key, is_on=lambda: ui.panels[name])

    return [
        Action(
            "Picture alone", "Window", ui.toggle_bare, _K.tab, is_on=lambda: ui.is_bare,
            is_alone=True,
        ),
        Action(
            "Full screen", "Window", ui.toggle_full_screen, _K.f11,
            is_on=lambda: ui.is_full_screen, is_alone=True,
        ),
        Action(
            "Second window with the picture", "Window", ui.toggle_feed, _K.f12,
            is_on=lambda: ui.has_feed, is_alone=True,
        ),
        Action(
            "Names of looks in the second window", "Window", ui.toggle_feed_labels,
            is_on=lambda: ui.has_feed_labels,
        ),
        *(panel(name) for name in PANELS if name != "Speed"),
        panel("Speed"),
        Action("Reset layout", "Window", ui.reset_layout),
        Action("Find a command...", "Help", ui.palette.open, _K.p | CTRL | SHIFT),
        Action("Go to the menus", "Help", ui.open_menus, _K.f10, is_alone=True),
        Action("Keys", "Help", ui.toggle_keys, _K.slash | SHIFT, is_alone=True),
    ]  # fmt: skip
