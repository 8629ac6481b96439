"""The list of actions."""

from dataclasses import replace
from typing import TYPE_CHECKING

from imgui_bundle import imgui

from heatlens.model.f_stops import stepped
from heatlens.model.settings import Bokeh, Method, Quality
from heatlens.model.view import DIFFERENCE_GAINS, Against, Compare, Overlay, ViewState
from heatlens.model.view_geometry import zoomed, zoomed_to
from heatlens.scene.scene_source import DEMO
from heatlens.ui.actions import _CTRL, _SHIFT, Action
from heatlens.ui.panel_names import PANELS
from heatlens.ui.panels.focus_bar import focused_at
from heatlens.ui.panels.lens_panel import barred_methods
from heatlens.ui.timeline.actions import key_actions, play_actions

if TYPE_CHECKING:
    from heatlens.ui.app import App

_K = imgui.Key
_NUDGE = 1 / 250  # of the focus bar
_EXPOSURE_STEP = 0.25  # stops
MENUS = ("File", "Edit", "Lens", "Play", "Animate", "View", "Compare", "Window", "Help")


def actions() -> tuple[Action, ...]:
    """All of them, in the order of the menus."""
    return (
        *(*_file(), *_edit(), *_lens(), *play_actions(), *key_actions(), *_scene()),
        *(*_view(), *_overlays(), *_compare(), *_window()),
    )


def _file() -> list[Action]:
    return [
        Action("Open...", "File", lambda app: app.browse("open"), _K.o, _CTRL),
        Action(
            "Open reference...", "File", lambda app: app.browse("reference"), _K.o, _CTRL | _SHIFT
        ),
        Action("Open the demo", "File", lambda app: app.open(DEMO)),
        Action("Start screen...", "File", lambda app: app.first.show()),
        Action("Open shot...", "File", lambda app: app.browse("shot")),
        Action("Save shot", "File", lambda app: app.documents.save(), _K.s, _CTRL | _SHIFT),
        Action("Save shot as...", "File", lambda app: app.browse("save shot")),
        Action("Reload", "File", lambda app: app.reload(), _K.r, _CTRL),
        Action("Save picture...", "File", lambda app: app.browse("save"), _K.s, _CTRL),
        Action("Take a camera...", "File", lambda app: app.browse("camera")),
        Action("Export...", "File", lambda app: app.filing.show_export(), _K.e, _CTRL),
        Action("Copy picture", "File", lambda app: app.copy_picture(), _K.c, _CTRL),
        Action("Quit", "File", lambda app: app.quit(), _K.q, _CTRL),
    ]


def _scene() -> list[Action]:
    return [
        Action(
            "Set camera key", "Animate", lambda app: app.scenes.set_key(), barred=_without_scene
        ),
        Action(
            "Frame what is chosen", "View", lambda app: app.scenes.frame_selected(),
            barred=_without_scene,
        ),
    ]  # fmt: skip


def _without_scene(app: "App") -> str:
    return "" if app.has_scene else "Only a scene has a camera and objects, and none is open."


def _edit() -> list[Action]:
    return [
        Action("Undo", "Edit", lambda app: app.undo(), _K.z, _CTRL, repeats=True),
        Action("Redo", "Edit", lambda app: app.redo(), _K.z, _CTRL | _SHIFT, repeats=True),
    ]


def nudge_focus(app: "App", notches: float) -> None:
    """Focus nearer (positive) or farther by so many notches of the bar."""
    histogram = app.histogram
    if histogram is not None:
        dioptres = 1.0 / app.lens.focus_distance_m
        step = notches * _NUDGE * histogram.most_dioptres
        app.edit_lens(focused_at(app.lens, max(dioptres + step, 0.0)))


def _focus_at_infinity(app: "App") -> None:
    if app.histogram is not None:
        app.edit_lens(focused_at(app.lens, 0.0))


def _step_f_stop(app: "App", steps: int) -> None:
    app.edit_lens(replace(app.lens, f_stop=stepped(app.lens.f_stop, steps)))


def _next_quality(app: "App") -> None:
    tiers = list(Quality)
    now = app.shot.defocus.quality
    after = tiers[(tiers.index(now) + 1) % len(tiers)]
    app.edit(replace(app.shot, defocus=replace(app.shot.defocus, quality=after)))


def _next_bokeh(app: "App") -> None:
    shapes = list(Bokeh)
    after = shapes[(shapes.index(app.shot.defocus.bokeh) + 1) % len(shapes)]
    app.edit(replace(app.shot, defocus=replace(app.shot.defocus, bokeh=after)))


def _lens() -> list[Action]:
    left, right = _K.left_bracket, _K.right_bracket
    return [
        Action("Focus nearer", "Lens", lambda app: nudge_focus(app, 1), left, repeats=True),
        Action("Focus farther", "Lens", lambda app: nudge_focus(app, -1), right, repeats=True),
        Action("Open a third", "Lens", lambda app: _step_f_stop(app, -1), left, _SHIFT, True),
        Action("Close a third", "Lens", lambda app: _step_f_stop(app, 1), right, _SHIFT, True),
        Action("Focus at infinity", "Lens", _focus_at_infinity),
        Action("Lens as it began", "Lens", lambda app: app.reset_lens()),
        Action("Next quality", "Lens", _next_quality, _K.q),
        Action("Next bokeh", "Lens", _next_bokeh, _K.b),
    ]


def _set(app: "App", **changes: object) -> None:
    app.view = replace(app.view, **changes)  # type: ignore[arg-type]


def _toggle_overlay(app: "App", overlay: Overlay) -> None:
    _set(app, overlay=Overlay.NONE if app.view.overlay is overlay else overlay)


def _toggle_compare(app: "App", compare: Compare) -> None:
    _set(app, compare=Compare.OFF if app.view.compare is compare else compare)


def _zoomed(app: "App", factor: float) -> ViewState:
    panel = app.viewport
    return zoomed(app.view, panel.viewport, app.picture_shape, factor, panel.viewport.middle)


def _one_to_one(app: "App") -> None:
    panel = app.viewport
    middle = panel.viewport.middle
    app.view = zoomed_to(app.view, panel.viewport, app.picture_shape, 1.0, middle)


def _view() -> list[Action]:
    def zoom(app: "App", factor: float) -> None:
        app.view = _zoomed(app, factor)

    def expose(app: "App", steps: int) -> None:
        _set(app, exposure_stops=app.view.exposure_stops + steps * _EXPOSURE_STEP)

    return [
        Action(
            "Depth of field", "View",
            lambda app: _set(app, depth_of_field=not app.view.depth_of_field), _K.d,
            is_on=lambda app: app.view.depth_of_field,
        ),
        Action("Fit", "View", lambda app: _set(app, zoom=None, center_px=None), _K.f),
        Action("1:1", "View", _one_to_one, _K._1),
        Action("Zoom in", "View", lambda app: zoom(app, 2.0), _K.equal, repeats=True),
        Action("Zoom out", "View", lambda app: zoom(app, 0.5), _K.minus, repeats=True),
        Action(
            "Pixel grid", "View", lambda app: _set(app, pixel_grid=not app.view.pixel_grid), _K.g,
            is_on=lambda app: app.view.pixel_grid,
        ),
        Action("Brighter", "View", lambda app: expose(app, 1), _K.up_arrow, _CTRL, True),
        Action("Darker", "View", lambda app: expose(app, -1), _K.down_arrow, _CTRL, True),
        Action(
            "Exposure and gamma back", "View", lambda app: _set(app, exposure_stops=0.0, gamma=1.0),
            _K._0, _CTRL,
        ),
        Action(
            "Metres or feet", "View",
            lambda app: _set(app, unit="ft" if app.view.unit == "m" else "m"), _K.u,
        ),
    ]  # fmt: skip


def _overlays() -> list[Action]:
    keyed = (
        (Overlay.ZONES, "Near, in focus, far", _K.z),
        (Overlay.FOCUS_PLANE, "Plane in focus", _K.p),
        (Overlay.COC, "Circle of confusion", _K.c),
        (Overlay.DEPTH, "Depth", _K.v),
        (Overlay.LAYERS, "Layers", _K.l),
    )
    return [
        Action(
            name, "View", lambda app, o=overlay: _toggle_overlay(app, o), key,  # type: ignore[misc]
            is_on=lambda app, o=overlay: app.view.overlay is o,  # type: ignore[misc]
        )
        for overlay, name, key in keyed
    ]  # fmt: skip


def _next_gain(app: "App", steps: int) -> None:
    nearest = min(DIFFERENCE_GAINS, key=lambda g: abs(g - app.view.difference_gain))
    index = DIFFERENCE_GAINS.index(nearest) + steps
    index = min(max(index, 0), len(DIFFERENCE_GAINS) - 1)
    _set(app, difference_gain=DIFFERENCE_GAINS[index])


def _swap_b(app: "App") -> None:
    is_reference = app.view.against is Against.REFERENCE
    other = Against.PINHOLE if is_reference else Against.REFERENCE
    if other is Against.REFERENCE and app.reference is None:
        app.say("No reference is loaded: open one with Ctrl+Shift+O.")
        return
    _set(app, against=other)


def _compare_with(app: "App", method: Method | None) -> None:
    """Have B be the pinhole picture, None, or the same shot by `method`, and show it."""
    compare = Compare.WIPE if app.view.compare is Compare.OFF else app.view.compare
    if method is None:
        _set(app, against=Against.PINHOLE, compare=compare)
    else:
        _set(app, against=Against.METHOD, b_method=method, compare=compare)


def _compare() -> list[Action]:
    keyed = (
        (Compare.WIPE, "Wipe", _K.w),
        (Compare.FLIP, "Flip to B", _K.x),
        (Compare.DIFFERENCE, "Difference", _K.e),
    )
    toggles = [
        Action(
            name, "Compare", lambda app, c=compare: _toggle_compare(app, c), key,  # type: ignore[misc]
            is_on=lambda app, c=compare: app.view.compare is c,  # type: ignore[misc]
        )
        for compare, name, key in keyed
    ]  # fmt: skip
    return [
        *toggles,
        Action("More gain", "Compare", lambda app: _next_gain(app, 1), _K.period),
        Action("Less gain", "Compare", lambda app: _next_gain(app, -1), _K.comma),
        Action(
            "B is the reference", "Compare", _swap_b, _K.r,
            is_on=lambda app: app.view.against is Against.REFERENCE,
        ),
        *(
            Action(
                f"Compare with {method or 'pinhole'}", "Compare",
                lambda app, m=method: _compare_with(app, m),  # type: ignore[misc]
                barred=lambda app, m=method: barred_methods(app.has_scene).get(str(m), ""),  # type: ignore[misc]
            )
            for method in (None, *Method)
        ),
    ]  # fmt: skip


def _window() -> list[Action]:
    def toggle(app: "App", name: str) -> None:
        app.panels[name] = not app.panels[name]

    shown = [
        Action(
            name, "Window", lambda app, n=name: toggle(app, n), key,  # type: ignore[misc]
            is_on=lambda app, n=name: app.panels[n],  # type: ignore[misc]
        )
        for name, key in (*((n, None) for n in PANELS if n != "Speed"), ("Speed", _K.t))
    ]  # fmt: skip
    return [
        *shown,
        Action("Reset layout", "Window", lambda app: app.reset_layout()),
        Action("Find a command...", "Help", lambda app: app.open_palette(), _K.p, _CTRL | _SHIFT),
        Action("Keys", "Help", lambda app: app.toggle_keys(), _K.slash, _SHIFT),
    ]
