"""What can be done on the timeline, by name and key."""

from imgui_bundle import imgui

from heatlens.ui.actions import _SHIFT, Action

_K = imgui.Key


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
    ]  # fmt: skip
