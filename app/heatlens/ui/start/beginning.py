"""What happens when a source was opened: a shot of it begins, or goes on."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from heatlens.errors import HeatlensError, LensError
from heatlens.model.shot import Shot
from heatlens.plate.start_lens import StartLens
from heatlens.session.given_camera import begun_with_camera, first_values
from heatlens.source.opened import Opened

if TYPE_CHECKING:
    from heatlens.ui.app import App


def begin(app: "App", opened: Opened) -> None:
    """Another file or renderer begins a shot, the same file read anew keeps it."""
    app.sides.restart()
    is_same = app.shot.source == opened.text
    coming = app.documents.taken(opened) if opened.source.is_repeatable else None
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
    elif opened.cache is not None:  # its files were read again, perhaps in another way
        app.edit(replace(app.shot, plate_options=opened.options))
    notes = " ".join((*opened.notes, _color_note(app, opened))).strip()
    if notes:
        app.say(notes)
    app.filing.arrived(opened)


def _color_note(app: "App", opened: Opened) -> str:
    """Have the colours of all frames mean what the first header tells; return what to say of it."""
    app.color.attributes = opened.attributes
    return app.color.input_of(app.view.input_space).note


def _started(app: "App", opened: Opened, begun: StartLens) -> Shot:
    return _filmed(app, opened.shot(begun.lens, app.shot.defocus))


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


def _first_lens(app: "App", opened: Opened) -> StartLens:
    """The command line's lens is for what it came with, and said where it cannot be."""
    try:
        return opened.lens(_given(app, opened.text))
    except LensError as error:
        app.say(str(error))
        return opened.lens({})


def _given(app: "App", source: str) -> Mapping[str, float]:
    """Fields of Lens that the command line tells of `source`, its camera's as they are first."""
    start = app.start
    if not app.first.came_with(source):
        return {}
    return {**first_values(start.camera, start.lens), **start.lens}
