"""A whole evening's work on a shot, without a window, a GPU or a screen.

`evening` is run in a process in which neither ImGui nor GLFW nor a context of OpenGL can be loaded.
"""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.core.model.marks.marks import PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import Quality
from heatlens.media.documents.shot_file import autosave_path, read_shot
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.studio.session.session import Session
from heatlens.studio.session.settings.preferences import Preferences
from heatlens.studio.session.shot.shot_store import unnamed_path
from heatlens.studio.session.shot.start import Start
from support.exr_files import write_file
from support.fake_renderer import FakeRenderer

FIRST, LAST = 1001, 1024
WIDTH, HEIGHT = 48, 32
NEAR_M, FAR_M = 2.0, 8.0  # of the left and the right half of the picture
LEFT, RIGHT = (8, 16), (40, 16)


def write_plates(folder: Path) -> str:
    """Write frames of two walls, one nearer than the other; return their pattern."""
    depth = np.full((HEIGHT, WIDTH), FAR_M, np.float32)
    depth[:, : WIDTH // 2] = NEAR_M
    grey = np.full((HEIGHT, WIDTH), 0.18, np.float16)
    channels = {"R": grey, "G": grey, "B": grey, "Z": depth}
    for frame in range(FIRST, LAST + 1):
        lens = lens_attributes(50.0, 2.8, 4.0, 36.0)
        write_file(folder / f"walls.{frame}.exr", channels, **lens)
    return str(folder / "walls.####.exr")


def session_of(folder: Path, renderer: Any = None, **start: Any) -> Session:
    """Return a session that has begun, with its preferences in `folder`."""
    preferences = Preferences.load(folder / "preferences")
    session = Session(renderer or FakeRenderer(), Start(**start), preferences=preferences)
    session.begin()
    return session


def begun(preferences: Path, source: str = "") -> Session:
    """Return the session as it begins."""
    renderer: Any = FakeRenderer()
    session = Session(renderer, Start(source), preferences=Preferences.load(preferences))
    session.begin()
    return session


def until(session: Session, condition: Callable[[], bool], what: str) -> None:
    """Make turns of the loop until `condition`; fail after a fixed number of them."""
    end, said = time.monotonic() + 60.0, ""
    while not condition():
        assert time.monotonic() < end, f"{what} never came. {said}"
        turn(session)
        said = session.messages.text or said
        time.sleep(0.001)


def turn(session: Session) -> None:
    """Make one turn of the loop, as the window does."""
    session.poll()
    session.time.scheduler.update()
    if session.time.scheduler.is_working:
        session.work()
    session.editing.rest(is_held=False)


def settled(session: Session) -> None:
    """Make turns until the whole picture is there, and everything that was changed is kept."""

    def is_settled() -> bool:
        is_kept = not (session.wants_frames or session.files.documents._writing)
        return (
            is_kept and session.source.plate is not None and not session.time.scheduler.is_working
        )

    until(session, is_settled, "rest")


def evening(folder: Path) -> None:
    """Open, focus, key a pull, mark, undo, save, export, close, and open again after a crash."""
    preferences, pattern = folder / "preferences", write_plates(folder)
    session = begun(preferences)
    assert session.files.start_choices.is_wanted and session.files.start_choices.has_nothing
    session.files.commands.open(pattern)
    settled(session)
    assert not session.files.start_choices.is_wanted
    assert (
        session.time.timeline.frames is not None
        and session.time.timeline.frames.count == LAST - FIRST + 1
    )
    _focus(session)
    _key_a_pull(session)
    shot_path = _save(session, folder)
    assert not autosave_path(unnamed_path(preferences, pattern)).exists()
    _export(session, folder)
    _crash(session, preferences, shot_path)
    _recover(preferences, shot_path)
    _begin_with_an_unnamed_shot(preferences, pattern)


def _focus(session: Session) -> None:
    """Click on the walls; one step back undoes one click."""
    assert session.facts.lens.focus_distance_m == 4.0  # as the header tells
    for pixel, distance_m in ((LEFT, NEAR_M), (RIGHT, FAR_M)):
        session.lens.commands.focus_at(pixel)
        session.editing.settle()
        assert session.facts.lens.focus_distance_m == distance_m
        settled(session)
        assert (
            session.pictures.live.shown is not None
            and session.pictures.live.shown.shot == session.facts.shot
        )
    session.editing.undo()
    assert session.facts.lens.focus_distance_m == NEAR_M
    session.editing.redo()
    session.lens.commands.step_f_stop(-3)
    assert round(session.facts.lens.f_stop, 1) == 2.0
    before = session.facts.shot.defocus.quality
    for _ in (None, *Quality):
        session.lens.commands.next_quality()
    assert session.facts.shot.defocus.quality is before


def _key_a_pull(session: Session) -> None:
    """Set marks on both walls, and pull from one to the other."""
    session.time.marks.set_point(LEFT)
    session.time.marks.set_point(RIGHT)
    near, far = session.facts.shot.marks
    assert isinstance(near, PointMark) and isinstance(far, PointMark)
    session.time.timeline.go(FIRST + 2)
    session.time.marks.pulls.origin, session.time.marks.pulls.target = near.name, far.name
    session.time.marks.pulls.lengthen(12)
    session.time.marks.pulls.make()
    until(session, lambda: not session.time.marks.distances.is_waited_for, "the pull")
    end = FIRST + 14
    ends = [session.facts.shot.lens_at(frame).focus_distance_m for frame in (FIRST, end, LAST)]
    np.testing.assert_allclose(ends, [NEAR_M, FAR_M, FAR_M])
    before = session.facts.shot
    session.time.keys.choose_all()
    session.time.keys.move(2)
    assert session.facts.shot.key_frames == tuple(frame + 2 for frame in before.key_frames)
    session.editing.undo()
    assert session.facts.shot == before
    session.time.timeline.set_in()
    assert session.time.timeline.played.first == FIRST + 2
    session.time.timeline.go_to_key(1)
    assert session.facts.frame == end
    settled(session)


def _save(session: Session, folder: Path) -> Path:
    """Save the shot to a file, which the title names."""
    assert not session.files.documents.save()  # it has no name yet
    path = folder / session.files.commands.first_name("save shot")
    session.files.documents.save_as(path)
    settled(session)
    assert read_shot(path) == session.facts.shot
    assert session.files.documents.is_saved and session.files.documents.title == path.name
    return path


def _export(session: Session, folder: Path) -> None:
    """Write the lens as a camera, in a process of its own."""
    session.files.exports.propose()
    session.files.exports.settings = session.files.exports.settings.__class__(
        str(folder / "out"), "walls"
    )
    session.files.exports.write_camera()
    until(session, lambda: not session.files.exports.run.is_busy, "the camera")
    until(session, lambda: "Done" in session.messages.text, "a word of it")
    assert (folder / "out" / "walls.usda").stat().st_size > 0


def _crash(session: Session, preferences: Path, path: Path) -> None:
    """Change the shot after it was saved, and end without a word."""
    session.lens.commands.focus(3.0)
    session.editing.settle()
    settled(session)
    assert autosave_path(path).exists() and not session.files.documents.is_saved
    session.remember()
    session.time.pull.close()
    session.source.close()
    session.files.documents.store.close()
    assert str(path) in Preferences.load(preferences).now.recent


def _recover(preferences: Path, path: Path) -> None:
    """Open the shot again: what was not saved is offered, and taken."""
    saved = read_shot(path)
    session = begun(preferences, str(path))
    until(session, lambda: session.files.documents.offer is not None, "the offer")
    session.files.documents.answer(goes_on=True)
    settled(session)
    assert session.files.documents.path == path and session.facts.shot != saved
    assert session.files.documents.title.endswith("*")
    session.files.documents.save()
    settled(session)
    assert read_shot(path) == session.facts.shot and not autosave_path(path).exists()
    keys = session.facts.shot.curves.of(LensParameter.FOCUS_DISTANCE).keys
    assert [key.value for key in keys] != [
        key.value for key in saved.curves.of(LensParameter.FOCUS_DISTANCE).keys
    ]
    session.close()


def _begin_with_an_unnamed_shot(preferences: Path, pattern: str) -> None:
    """Check that a shot without a file is kept beside its plate, and offered with it."""
    session = begun(preferences, pattern)
    settled(session)
    session.time.keys.set_here()
    settled(session)
    worked_on, kept = session.facts.shot, autosave_path(unnamed_path(preferences, pattern))
    assert kept.exists()
    session.close()
    again = begun(preferences, pattern)
    until(again, lambda: again.files.documents.offer is not None, "the offer")
    again.files.documents.answer(goes_on=True)
    assert again.facts.shot == worked_on
    settled(again)
    again.close()
