"""What can be done on the timeline, by name and key."""

from typing import TYPE_CHECKING

from imgui_bundle import imgui

from heatlens.model.interpolation import Interpolation
from heatlens.ui.actions import _CTRL, _SHIFT, Action

if TYPE_CHECKING:
    from heatlens.ui.app import App

_K = imgui.Key
_BOTH = _CTRL | _SHIFT


def play_actions() -> list[Action]:
    """Of the playhead."""
    return [
        Action("Play or stop", "Play", lambda app: app.timeline.play(1), _K.space),
        Action("Play backwards", "Play", lambda app: app.timeline.play(-1), _K.space, _SHIFT),
        Action("Next frame", "Play", lambda app: app.timeline.step(1), _K.right_arrow, 0, True),
        Action("Previous frame", "Play", lambda app: app.timeline.step(-1), _K.left_arrow, 0, True),
        Action("First frame", "Play", lambda app: app.timeline.go_to_end(-1), _K.home),
        Action("Last frame", "Play", lambda app: app.timeline.go_to_end(1), _K.end),
        Action("Next key", "Play", lambda app: app.timeline.go_to_key(1), _K.down_arrow),
        Action("Previous key", "Play", lambda app: app.timeline.go_to_key(-1), _K.up_arrow),
        Action("In point here", "Play", lambda app: app.timeline.set_in(), _K.i),
        Action("Out point here", "Play", lambda app: app.timeline.set_out(), _K.o),
        Action("In and out points away", "Play", lambda app: app.timeline.play_all(), _K.i, _SHIFT),
        Action(
            "Render frames ahead", "Play", lambda app: app.pull.switch(),
            is_on=lambda app: app.filing.preferences.now.keep_frames,
        ),
        Action("Clear rendered frames", "Play", lambda app: app.pull.clear()),
        Action("Rendered frames...", "Play", lambda app: app.pull.open_popup()),
    ]  # fmt: skip


def key_actions() -> list[Action]:
    """Of the keys; where none are chosen, those at the playhead are meant."""
    later, earlier = _K.right_arrow, _K.left_arrow
    return [
        Action("Set key", "Animate", lambda app: app.timeline.keys.set_here(), _K.k),
        Action("Delete keys", "Animate", lambda app: app.timeline.keys.delete(), _K.delete),
        Action("Set mark here", "Animate", lambda app: app.timeline.marks.set_here(), _K.m),
        Action("Pull focus...", "Animate", lambda app: app.timeline.open_pull(), _K.m, _SHIFT),
        Action(
            "Auto key", "Animate", _toggle_auto_key, _K.a, is_on=lambda app: app.editing.auto_key
        ),
        Action("All keys", "Animate", lambda app: app.timeline.keys.choose_all(), _K.a, _BOTH),
        Action("Copy keys", "Animate", lambda app: app.timeline.keys.copy(), _K.c, _BOTH),
        Action("Paste keys", "Animate", lambda app: app.timeline.keys.paste(), _K.v, _BOTH),
        Action("Keys later", "Animate", lambda app: app.timeline.keys.move(1), later, _BOTH, True),
        Action(
            "Keys earlier", "Animate", lambda app: app.timeline.keys.move(-1), earlier, _BOTH, True
        ),
        *(
            Action(
                f"Path after key: {interpolation}", "Animate",
                lambda app, i=interpolation: app.timeline.keys.interpolate(i),  # type: ignore[misc]
            )
            for interpolation in Interpolation
        ),
        Action(
            "Curve of the row", "Animate", _toggle_curve, _K.c, _SHIFT,
            is_on=lambda app: app.timeline.shows_curve,
        ),
    ]  # fmt: skip


def _toggle_auto_key(app: "App") -> None:
    app.editing.auto_key = not app.editing.auto_key


def _toggle_curve(app: "App") -> None:
    app.timeline.shows_curve = not app.timeline.shows_curve
