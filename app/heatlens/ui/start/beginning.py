"""What happens when a plate, a scene or a stream was opened: a shot begins, or goes on."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from heatlens.errors import HeatlensError, LensError
from heatlens.model.shot import Shot
from heatlens.plate.start_lens import StartLens, start_lens
from heatlens.session.given_camera import begun_with_camera, first_values
from heatlens.session.plate_opening import Opened
from heatlens.session.scene_opening import OpenedScene
from heatlens.session.stream_source import OpenedStream
from heatlens.ui.files.shot_documents import started_shot

if TYPE_CHECKING:
    from heatlens.ui.app import App


def begin(app: "App", opened: Opened | OpenedScene | OpenedStream) -> None:
    """Another file or renderer begins a shot, the same file read anew keeps it."""
    app.sides.restart()
    is_same = app.shot.source == opened.text
    coming = None if isinstance(opened, OpenedStream) else app.documents.taken(opened)
    app.editing.frame = opened.frame
    app.message = ""
    app.first.begun(opened.text)
    app.begun = _first_lens(app, opened)
    if coming is not None:
        app.editing.begin(coming)
    elif not is_same:
        app.editing.begin(_started(app, opened, app.begun))
        app.documents.begun()
        app.view = replace(app.view, zoom=None, center_px=None)
    elif isinstance(opened, Opened):
        app.edit(replace(app.shot, plate_options=opened.options))
    notes = " ".join((*_notes(opened), _color_note(app, opened))).strip()
    if notes:
        app.say(notes)
    app.filing.arrived(opened)


def _notes(opened: Opened | OpenedScene | OpenedStream) -> tuple[str, ...]:
    return opened.scene.notes if isinstance(opened, OpenedScene) else opened.plate.notes


def _color_note(app: "App", opened: Opened | OpenedScene | OpenedStream) -> str:
    """Have the colours mean what the header tells, the same for all frames; a scene's is none."""
    app.color.attributes = opened.plate.attributes if isinstance(opened, Opened) else {}
    return app.color.input_of(app.view.input_space).note


def _started(app: "App", opened: Opened | OpenedScene | OpenedStream, begun: StartLens) -> Shot:
    if isinstance(opened, OpenedStream):
        shot = Shot(begun.lens, app.shot.defocus, opened.text, opened.options)
    else:
        shot = started_shot(opened, begun.lens, app.shot.defocus)
    return _filmed(app, shot)


def _filmed(app: "App", shot: Shot) -> Shot:
    """The command line's camera, too, is for what it came with. A still has its frames."""
    source = shot.source or ""
    if app.start.camera is None or not app.first.came_with(source):
        return shot
    given = _given(app, source)
    if any(getattr(shot.lens, name) != value for name, value in given.items()):
        return shot  # they make no lens, which was said
    try:
        filmed = begun_with_camera(shot, app.start.camera, app.start.lens)
    except HeatlensError as error:
        app.say(str(error))
        return shot
    if shot.frames is None:
        app.editing.frame = app.start.camera.frames[0]
    return filmed


def _first_lens(app: "App", opened: Opened | OpenedScene | OpenedStream) -> StartLens:
    """The command line's lens is for what it came with, and said where it cannot be."""
    try:
        return _lens_of(opened, _given(app, opened.text))
    except LensError as error:
        app.say(str(error))
        return _lens_of(opened, {})


def _given(app: "App", source: str) -> Mapping[str, float]:
    """Fields of Lens that the command line tells of `source`, its camera's as they are first."""
    start = app.start
    if not app.first.came_with(source):
        return {}
    return {**first_values(start.camera, start.lens), **start.lens}


def _lens_of(opened: Opened | OpenedScene | OpenedStream, given: Mapping[str, float]) -> StartLens:
    if isinstance(opened, OpenedScene):
        return StartLens(replace(opened.shot.lens, **given), dict.fromkeys(given, "given"))
    return start_lens(opened.plate, given)
