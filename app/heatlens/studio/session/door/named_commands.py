"""List the named commands of a session, which menus, keys, palette and other front ends offer.

A command is one thing that the user can do without further values, known by its name.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.shot.settings import Method, barred_methods
from heatlens.core.model.view import overlays
from heatlens.core.model.view.guides import MATTES
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.media.scene.scene_read import DEMO
from heatlens.studio.session.session import Session

LOOKS_NAMED = 9  # looks with a command of their own
_COMPARED = {Compare.WIPE: "Wipe", Compare.FLIP: "Flip to B", Compare.DIFFERENCE: "Difference"}
_DOLLY_ZOOMS: dict[str, Literal["camera", "length"]] = {
    "Camera follows the focal length": "camera",
    "Focal length follows the camera": "length",
}
_GUIDE_LINES = {"safe_areas": "Safe areas", "thirds": "Thirds", "centre": "Centre cross"}


@dataclass(frozen=True, eq=False)
class Command:
    """One thing the user can do.

    name    unique name
    menu    title of its menu
    run     the function that does it
    is_on   returns the state of a switch; None for commands that switch nothing
    barred  returns the reason why the command is unavailable now, or ""
    label   returns the text that a menu shows instead of the name
    """

    name: str
    menu: str
    run: Callable[[], object]
    is_on: Callable[[], bool] | None = None
    barred: Callable[[], str] | None = None
    label: Callable[[], str] | None = None

    @property
    def shown(self) -> str:
        """The text in the menu: `label()` where the command has one, else the name."""
        return self.name if self.label is None else self.label()

    def why_not(self) -> str:
        """Return the reason, a sentence, why the command is unavailable now; else ""."""
        return "" if self.barred is None else self.barred()

    def do(self) -> None:
        """Run the command. Raise InputError with the reason if it is unavailable."""
        why = self.why_not()
        if why:
            raise InputError(why)
        self.run()


def named_commands(session: Session) -> tuple[Command, ...]:
    """Return the commands that need no further values, in the order of their menus."""
    return (
        *(*_file(session), *_edit(session), *_lens(session), *_play(session), *_keys(session)),
        *(*_view(session), *_overlays(session), *_guides(session), *_scene(session)),
        *_compare(session),
    )


def _file(session: Session) -> Iterator[Command]:
    files = session.files
    yield Command("Open the demo", "File", partial(files.commands.open, DEMO))
    yield Command("Start screen...", "File", files.start_choices.show)
    yield Command("Reload", "File", files.commands.reload)
    yield Command("Copy picture", "File", session.pictures.saving.copy)
    reel = files.reel
    for name, by in (("Next shot", 1), ("Previous shot", -1)):
        yield Command(name, "Play", partial(reel.step, by), barred=lambda: reel.why_not)


def _edit(session: Session) -> Iterator[Command]:
    editing = session.editing
    yield _of_history("Undo", editing.undo, lambda: editing.history.undo_words)
    yield _of_history("Redo", editing.redo, lambda: editing.history.redo_words)


def _of_history(name: str, run: Callable[[], object], words: Callable[[], str]) -> Command:
    """Return undo or redo; `words` names the change to undo or redo, "" for none."""
    return Command(
        *(name, "Edit", run),
        barred=lambda: "" if words() else f"There is nothing to {name.lower()}.",
        label=lambda: f"{name} {words()}".strip(),
    )


def _lens(session: Session) -> Iterator[Command]:
    lens, looks = session.lens.commands, session.pictures.looks
    yield Command("Focus nearer", "Lens", partial(lens.nudge_focus, 1))
    yield Command("Focus farther", "Lens", partial(lens.nudge_focus, -1))
    yield Command("Open 1/3 stop", "Lens", partial(lens.step_f_stop, -1))
    yield Command("Close 1/3 stop", "Lens", partial(lens.step_f_stop, 1))
    yield Command("Focus at infinity", "Lens", lens.focus_at_infinity)
    yield Command("Focus on the other surface here", "Lens", lens.focus_on_other)
    yield Command("Reset lens", "Lens", lens.reset)
    yield Command("Keep the size of a mark", "Lens", session.scenes.size.switch)
    yield Command("Keep this look", "Lens", looks.keep)
    yield Command("Back to the lens before", "Lens", looks.back)
    for index in range(LOOKS_NAMED):
        yield Command(f"Look {index + 1}", "Lens", partial(looks.go, index))
    yield Command("Next quality", "Lens", lens.next_quality)
    yield Command("Next bokeh", "Lens", lens.next_bokeh)


def _play(session: Session) -> Iterator[Command]:
    time, pull = session.time.timeline, session.time.pull
    yield Command("Play or stop", "Play", partial(time.play, 1))
    yield Command("Play backwards", "Play", partial(time.play, -1))
    yield Command("Next frame", "Play", partial(time.step, 1))
    yield Command("Previous frame", "Play", partial(time.step, -1))
    yield Command("First frame", "Play", partial(time.go_to_end, -1))
    yield Command("Last frame", "Play", partial(time.go_to_end, 1))
    yield Command("Next key", "Play", partial(time.go_to_key, 1))
    yield Command("Previous key", "Play", partial(time.go_to_key, -1))
    yield Command("Set in point", "Play", time.set_in)
    yield Command("Set out point", "Play", time.set_out)
    yield Command("Clear in and out", "Play", time.clear_in_out)
    keeps = session.preferences
    yield Command("Render frames ahead", "Play", pull.switch, lambda: keeps.now.keep_frames)
    yield Command("Clear rendered frames", "Play", pull.clear)


def _keys(session: Session) -> Iterator[Command]:
    """Yield the commands on keys: the selected ones, or those at the playhead if none are."""
    editing, keys, marks = session.editing, session.time.keys, session.time.marks
    recording, rows = session.time.recording, session.time.keys.rows
    yield Command("Set key", "Animate", keys.set_here)
    yield Command("Delete keys", "Animate", keys.delete)
    yield Command("Set mark here", "Animate", marks.set_here)
    yield Command("Reverse the pull", "Animate", marks.pulls.reverse)
    yield Command("Record a pull", "Animate", recording.arm, barred=lambda: recording.why_not)
    yield Command("Hold the focus from here", "Animate", marks.pulls.hold)
    yield Command("Auto key", "Animate", editing.toggle_auto_key, lambda: editing.auto_key)
    yield Command("Select all keys", "Animate", keys.choose_all)
    yield Command("Copy keys", "Animate", keys.copy)
    yield Command("Paste keys", "Animate", keys.paste)
    yield Command("Move keys later", "Animate", partial(keys.move, 1))
    yield Command("Move keys earlier", "Animate", partial(keys.move, -1))
    for how in Interpolation:
        name = f"Interpolate {how} after key"
        yield Command(name, "Animate", partial(keys.interpolate, how))
    yield Command("Show curve", "Animate", rows.toggle_curve, lambda: rows.shows_curve)


def _scene(session: Session) -> Iterator[Command]:
    def barred() -> str:
        is_there = session.facts.has_camera
        return "" if is_there else "Only a scene has a camera and objects, and none is open."

    scenes = session.scenes
    yield Command("Set camera key", "Animate", scenes.set_key, barred=barred)
    for name, by in _DOLLY_ZOOMS.items():
        yield Command(name, "Animate", partial(scenes.size.dolly_zoom, by), barred=barred)
    yield Command("Frame selected", "View", scenes.frame_selected, barred=barred)


def _switch(
    session: Session, name: str, run: Callable[[], None], is_on: Callable[[ViewState], bool]
) -> Command:
    return Command(name, "View", run, lambda: is_on(session.facts.view))


def _view(session: Session) -> Iterator[Command]:
    view = session.pictures.commands
    for field, name in (
        ("depth_of_field", "Depth of field"),
        ("pixel_grid", "Pixel grid"),
        ("pixel_values", "Values in pixels"),
        ("is_peaking", "Focus peaking"),
        ("loupe", "Loupe"),
    ):
        is_on = partial(lambda field, view: bool(getattr(view, field)), field)
        yield _switch(session, name, partial(view.toggle, field), is_on)
    yield Command(
        *("Grade of the shot", "View", partial(view.toggle, "is_graded")),
        lambda: session.facts.view.is_graded,
        lambda: "" if session.facts.shot.grade else "The shot has no grade (ASC CDL).",
    )
    yield Command("Fit", "View", view.fit)
    yield Command("1:1", "View", view.one_to_one)
    yield Command("Zoom in", "View", partial(view.zoom, 2.0))
    yield Command("Zoom out", "View", partial(view.zoom, 0.5))
    ruler = view.ruler
    yield Command("Ruler", "View", view.toggle_ruler, lambda: ruler.is_on, ruler.why_not)
    yield Command("Brighter", "View", partial(view.expose, 1))
    yield Command("Darker", "View", partial(view.expose, -1))
    yield Command("Reset exposure and gamma", "View", view.reset_exposure_and_gamma)
    yield Command("Metres or feet", "View", view.toggle_unit)


def _overlays(session: Session) -> Iterator[Command]:
    for overlay in overlays.OVERLAYS:
        is_on = partial(lambda name, view: view.overlay == name, overlay.name)
        toggle = partial(session.pictures.commands.toggle_overlay, overlay.name)
        yield _switch(session, overlay.words, toggle, is_on)


def _guides(session: Session) -> Iterator[Command]:
    view = session.pictures.commands
    for name, aspect in MATTES.items():
        is_on = partial(lambda aspect, view: view.guides.aspect == aspect, aspect)
        yield _switch(session, f"Matte {name}", partial(view.toggle_matte, aspect), is_on)
    for field, name in _GUIDE_LINES.items():
        is_on = partial(lambda field, view: bool(getattr(view.guides, field)), field)
        yield _switch(session, name, partial(view.toggle_guide, field), is_on)


def _compare(session: Session) -> Iterator[Command]:
    view, now = session.pictures.commands, session.facts
    for compare, name in _COMPARED.items():
        is_on = partial(lambda compare: now.view.compare is compare, compare)
        yield Command(name, "Compare", partial(view.toggle_compare, compare), is_on)
    yield Command(
        *("Grid of looks", "Compare", session.pictures.looks.toggle_grid),
        lambda: now.view.compare is Compare.GRID,
    )
    yield Command("More gain", "Compare", partial(view.step_gain, 1))
    yield Command("Less gain", "Compare", partial(view.step_gain, -1))
    yield Command(
        *("B is the reference", "Compare", view.swap_b),
        lambda: now.view.against is Against.REFERENCE,
    )
    for method in (None, *Method):
        yield Command(
            *(f"Compare with {method or 'pinhole'}", "Compare"),
            partial(view.compare_with, method),
            barred=partial(lambda it: barred_methods(now.has_many_views).get(str(it), ""), method),
        )
