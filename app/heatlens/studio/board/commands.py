"""List the commands of a session, which menus, keys, palette and all other front ends offer.

Another command is another entry here or in `picture_commands.py`; one on the window alone is one in
`ui/window_commands.py`.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Literal

from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.media.scene.scene_read import DEMO
from heatlens.studio.board.command import Command, in_group, page_command, remote_command
from heatlens.studio.board.picture_commands import picture_commands
from heatlens.studio.board.session import Session

_LOOKS_NAMED = 9  # looks with a command of their own
_DOLLY_ZOOMS: dict[str, Literal["camera", "length"]] = {
    "Camera follows the focal length": "camera",
    "Focal length follows the camera": "length",
}


def named_commands(
    session: Session, make_still: Callable[[], str | None] = lambda: None
) -> tuple[Command, ...]:
    """Return the commands that need no further values; for `make_still` see `Board`."""
    return (
        *(*_file(session), *_edit(session), *_lens(session, make_still)),
        *(*_play(session), *_keys(session), *_marks(session), *picture_commands(session)),
        *_scene(session),
    )


def _file(session: Session) -> Iterator[Command]:
    """Yield the commands on files, and those on the shots of a reel."""
    files, reel = session.files, session.files.reel
    yield from in_group(
        *("File", "open"),
        Command("Open the demo", partial(files.commands.open, DEMO)),
        Command("Start screen", files.start_choices.show),
    )
    yield from in_group("File", "shot", Command("Reload", files.commands.reload, "Ctrl+R"))
    yield from in_group(
        "File", "write", Command("Copy picture", session.pictures.saving.copy, "Ctrl+C")
    )
    barred = lambda: reel.why_not  # noqa: E731
    yield from in_group(
        *("Play", "reel"),
        Command("Next shot", partial(reel.step, 1), "Ctrl+Right", barred=barred),
        Command("Previous shot", partial(reel.step, -1), "Ctrl+Left", barred=barred),
        Command("Leave the reel", reel.leave, barred=barred),
    )


def _edit(session: Session) -> Iterator[Command]:
    """Yield undo and redo."""
    editing = session.editing
    yield from in_group(
        *("Edit", "history"),
        _of_history("Undo", editing.undo, lambda: editing.history.undo_words, "Ctrl+Z"),
        _of_history("Redo", editing.redo, lambda: editing.history.redo_words, "Ctrl+Shift+Z"),
    )


def _of_history(
    name: str, run: Callable[[], object], words: Callable[[], str], key: str
) -> Command:
    """Return undo or redo; `words` names the change to undo or redo, "" for none."""
    return page_command(
        *(name, run, key),
        barred=lambda: "" if words() else f"There is nothing to {name.lower()}.",
        label=lambda: f"{name} {words()}".strip(),
        repeats=True,
        sheet="Undo",
    )


def _lens(session: Session, make_still: Callable[[], str | None]) -> Iterator[Command]:
    """Yield the commands on the lens: rings, focus, looks and settings of the blur."""
    lens, looks = session.lens.commands, session.pictures.looks
    yield from in_group(
        *("Lens", "turn"),
        page_command("Focus nearer", partial(lens.nudge_focus, 1), "[", repeats=True),
        page_command("Focus farther", partial(lens.nudge_focus, -1), "]", repeats=True),
        page_command("Open 1/3 stop", partial(lens.step_f_stop, -1), "Shift+[", repeats=True),
        page_command("Close 1/3 stop", partial(lens.step_f_stop, 1), "Shift+]", repeats=True),
    )
    yield from in_group(
        *("Lens", "focus"),
        remote_command("Focus at infinity", lens.focus_at_infinity, sheet="Focus"),
        remote_command("Focus on the other surface here", lens.focus_on_other, "Y"),
        remote_command("Reset lens", lens.reset),
        remote_command("Keep the size of a mark", session.scenes.size.switch, "S"),
    )
    yield from in_group(
        *("Lens", "looks"),
        page_command("Keep this look", lambda: looks.keep(make_still()), "Shift+L"),
        page_command("Back to the lens before", looks.use_previous_lens, "Backspace"),
    )
    yield from in_group(
        *("Lens", "numbered looks"),
        *(
            remote_command(
                f"Look {number}", partial(looks.use_number, number - 1), f"Ctrl+{number}"
            )
            for number in range(1, _LOOKS_NAMED + 1)
        ),
    )
    yield from in_group(
        *("Lens", "blur"),
        Command("Next quality", lens.next_quality, "Q"),
        Command("Next bokeh", lens.next_bokeh, "B"),
    )


def _play(session: Session) -> Iterator[Command]:
    """Yield commands for the Play menu."""
    time, frames_ahead = session.time.timeline, session.time.frames_ahead
    yield from in_group(
        *("Play", "play"),
        page_command("Play or stop", partial(time.play, 1), "Space"),
        page_command("Play backwards", partial(time.play, -1), "Shift+Space"),
        page_command("Next frame", partial(time.step, 1), "Right", repeats=True),
        page_command("Previous frame", partial(time.step, -1), "Left", repeats=True),
    )
    yield from in_group(
        *("Play", "go to"),
        page_command("First frame", partial(time.go_to_end, -1), "Home"),
        page_command("Last frame", partial(time.go_to_end, 1), "End"),
        page_command("Next key", partial(time.go_to_key, 1), "Down"),
        page_command("Previous key", partial(time.go_to_key, -1), "Up"),
    )
    keeps = session.preferences
    ahead = Command(
        "Render frames ahead", frames_ahead.switch, is_on=lambda: keeps.values.keep_frames
    )
    yield from in_group(
        *("Play", "range"),
        page_command("Set in point", time.set_in, "I"),
        page_command("Set out point", time.set_out, "O"),
        page_command("Clear in and out", time.clear_in_out, "Shift+I"),
    )
    yield from in_group(
        "Play", "frames", ahead, Command("Clear rendered frames", frames_ahead.clear)
    )


def _keys(session: Session) -> Iterator[Command]:
    """Yield the commands on keys: the selected ones, or those at the playhead if none are."""
    editing, keys, rows = session.editing, session.time.keys, session.time.keys.rows
    yield from in_group(
        *("Animate", "key"),
        page_command("Set key", keys.set_here, "K", sheet="Focus"),
        page_command("Delete keys", keys.delete, "Delete"),
    )
    auto_key = page_command(
        *("Auto key", editing.toggle_auto_key, "A"), is_on=lambda: editing.auto_key, sheet="Focus"
    )
    yield from in_group("Animate", "auto key", auto_key)
    yield from in_group(
        *("Animate", "moves"),
        remote_command("Select all keys", keys.select_all, "Ctrl+Shift+A"),
        remote_command("Copy keys", keys.copy, "Ctrl+Shift+C"),
        remote_command("Paste keys", keys.paste, "Ctrl+Shift+V"),
        remote_command("Move keys later", partial(keys.move, 1), "Ctrl+Shift+Right", repeats=True),
        remote_command(
            "Move keys earlier", partial(keys.move, -1), "Ctrl+Shift+Left", repeats=True
        ),
    )
    yield from in_group(
        *("Animate", "interpolation"),
        *(
            remote_command(f"Interpolate {how} after key", partial(keys.interpolate, how))
            for how in Interpolation
        ),
    )
    curve = remote_command(
        "Show curve", rows.toggle_curve, "Shift+C", is_on=lambda: rows.shows_curve
    )
    yield from in_group("Animate", "rows", curve)


def _marks(session: Session) -> Iterator[Command]:
    """Yield the commands on marks and pulls."""
    marks, recording = session.time.marks, session.time.recording
    record = page_command(
        "Record a pull", recording.arm, "Shift+R", barred=lambda: recording.why_not
    )
    yield from in_group(
        *("Animate", "marks"),
        page_command("Set mark here", marks.set_here, "M", sheet="Focus"),
        remote_command("Reverse the pull", marks.pulls.reverse),
        record,
        page_command("Hold the focus from here", marks.pulls.hold_focus, "H", sheet="Focus"),
    )


def _scene(session: Session) -> Iterator[Command]:
    """Yield the commands that need the camera of a scene."""

    def barred() -> str:
        is_there = session.source.has_camera
        return "" if is_there else "Only a scene has a camera and objects, and none is open."

    scenes = session.scenes
    yield from in_group(
        *("Animate", "rows"),
        remote_command("Set camera key", scenes.set_key, barred=barred),
        *(
            remote_command(name, partial(scenes.size.dolly_zoom, by), barred=barred)
            for name, by in _DOLLY_ZOOMS.items()
        ),
    )
    framed = remote_command("Frame the object", scenes.frame_selected, barred=barred)
    yield from in_group("View", "camera", framed)
