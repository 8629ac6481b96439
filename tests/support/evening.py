"""A long work session on a shot, without a window, a GPU or a screen.

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
from heatlens.media.documents.shot_file import autosave_path, read_shot, unnamed_path
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.render.display.front_end import FrontEnd
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.board.loop_turn import LoopTurn
from heatlens.studio.board.session import Session
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.exr_files import write_file
from support.fake_renderer import FakeRenderer
from support.patience import PATIENCE_S

FIRST, LAST = 1001, 1024
WIDTH, HEIGHT = 48, 32
NEAR_M, FAR_M = 2.0, 8.0  # of the left and the right half of the picture
LEFT, RIGHT = (8, 16), (40, 16)
_SHORTEST_PAUSE_S, _LONGEST_PAUSE_S = 0.001, 0.02


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


def session_of(
    folder: Path, renderer: Any = None, screen: ScreenPictures | None = None, **start: Any
) -> Session:
    """Return a started session with its preferences in `folder`."""
    preferences = Preferences.load(folder / "preferences")
    front_end = FrontEnd(screen=screen, has_window=screen is not None)
    session = Session(renderer or FakeRenderer(), Start(**start), front_end, preferences)
    session.begin()
    return session


def begin_session(preferences: Path, source: str = "") -> Session:
    """Return a started session with a fake renderer."""
    renderer: Any = FakeRenderer()
    session = Session(renderer, Start(source), preferences=Preferences.load(preferences))
    session.begin()
    return session


def run_until(session: Session, condition: Callable[[], bool], label: str) -> None:
    """Run the session's loop until `condition` is true; fail after 60 s.

    Where the session has nothing to do, it waits longer and longer, up to 20 ms: another process
    works then, and needs the processors.
    """
    end, message = time.monotonic() + PATIENCE_S, ""
    pause_s = _SHORTEST_PAUSE_S
    while not condition():
        assert time.monotonic() < end, f"{label} never came. {message}"
        run_loop_once(session)
        message = session.messages.text or message
        is_working = session.time.scheduler.is_working
        pause_s = _SHORTEST_PAUSE_S if is_working else min(1.2 * pause_s, _LONGEST_PAUSE_S)
        time.sleep(pause_s)


def wait_for_all_frames(session: Session, count: int) -> None:
    """Run the session until `count` frames are rendered ahead and stored."""
    ahead = session.time.frames_ahead
    run_until(session, lambda: len(ahead.progress.rendered_frames) == count, f"{count} frames")
    ahead.store.wait()
    run_loop_once(session)


def run_loop_once(session: Session) -> None:
    """Make one turn of the loop, as the window does."""
    turn = LoopTurn(session)
    turn.make_frame()
    turn.work()


def run_until_settled(session: Session) -> None:
    """Run the loop until the picture is whole, marks are tracked and all changes are saved."""

    def is_settled() -> bool:
        if session.time.marks.anchors.tracking.is_busy:
            return False
        is_kept = not (session.wants_frames or session.files.documents._writes)
        return (
            is_kept and session.source.plate is not None and not session.time.scheduler.is_working
        )

    run_until(session, is_settled, "rest")


def evening(folder: Path) -> None:
    """Open, focus, key a pull, mark, undo, save, export, close, and open again after a crash."""
    preferences, pattern = folder / "preferences", write_plates(folder)
    session = begin_session(preferences)
    assert session.files.start_choices.is_shown and session.files.start_choices.is_nothing_open
    session.files.commands.open(pattern)
    run_until_settled(session)
    assert not session.files.start_choices.is_shown
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
    """Focus on both walls by clicks, and check undo, redo, f-stop steps and quality."""
    assert session.facts.lens.focus_distance_m == 4.0  # as the header tells
    for pixel, distance_m in ((LEFT, NEAR_M), (RIGHT, FAR_M)):
        session.lens.commands.focus_at(pixel)
        session.editing.settle()
        assert session.facts.lens.focus_distance_m == distance_m
        run_until_settled(session)
        assert (
            session.pictures.live.output is not None
            and session.pictures.live.output.shot == session.facts.shot
        )
    session.editing.undo()
    assert session.facts.lens.focus_distance_m == NEAR_M
    session.editing.redo()
    session.lens.commands.step_f_stop(-3)
    assert round(session.facts.lens.f_stop, 1) == 2.0
    quality_before = session.facts.shot.defocus.quality
    for _ in (None, *Quality):
        session.lens.commands.next_quality()
    assert session.facts.shot.defocus.quality is quality_before


def _key_a_pull(session: Session) -> None:
    """Set marks on both walls, and pull from one to the other."""
    session.time.marks.set_point(LEFT)
    session.time.marks.set_point(RIGHT)
    near, far = session.facts.shot.marks
    assert isinstance(near, PointMark) and isinstance(far, PointMark)
    session.time.timeline.go_to(FIRST + 2)
    session.time.marks.pulls.origin, session.time.marks.pulls.target = near.name, far.name
    session.time.marks.pulls.set_length(12)
    session.time.marks.pulls.make()
    run_until(session, lambda: not session.time.marks.distances.has_request, "the pull")
    end = FIRST + 14
    ends = [session.facts.shot.lens_at(frame).focus_distance_m for frame in (FIRST, end, LAST)]
    np.testing.assert_allclose(ends, [NEAR_M, FAR_M, FAR_M])
    shot_before = session.facts.shot
    session.time.keys.select_all()
    session.time.keys.move(2)
    assert session.facts.shot.key_frames == tuple(frame + 2 for frame in shot_before.key_frames)
    session.editing.undo()
    assert session.facts.shot == shot_before
    session.time.timeline.set_in()
    assert session.time.timeline.played.first == FIRST + 2
    session.time.timeline.go_to_key(1)
    assert session.facts.frame == end
    run_until_settled(session)


def _save(session: Session, folder: Path) -> Path:
    """Save the shot to a file, which the title names."""
    assert not session.files.documents.save()  # it has no name yet
    path = folder / session.files.commands.first_name("save shot")
    session.files.documents.save_as(path)
    run_until_settled(session)
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
    run_until(session, lambda: not session.files.exports.run.is_busy, "the camera")
    run_until(session, lambda: "Done" in session.messages.text, "a word of it")
    assert (folder / "out" / "walls.usda").stat().st_size > 0


def _crash(session: Session, preferences: Path, path: Path) -> None:
    """Change the shot after saving, and end the session as a crash would."""
    session.lens.commands.focus(3.0)
    session.editing.settle()
    run_until_settled(session)
    assert autosave_path(path).exists() and not session.files.documents.is_saved
    session.save_preferences()
    session.time.frames_ahead.close()
    session.source.close()
    session.files.documents.store.close()
    assert str(path) in Preferences.load(preferences).values.recent


def _recover(preferences: Path, path: Path) -> None:
    """Open the shot again, and accept the offered autosave."""
    saved = read_shot(path)
    session = begin_session(preferences, str(path))
    run_until(session, lambda: session.files.documents.offer is not None, "the offer")
    session.files.documents.answer(recovers=True)
    run_until_settled(session)
    assert session.files.documents.path == path and session.facts.shot != saved
    assert session.files.documents.title.endswith("*")
    session.files.documents.save()
    run_until_settled(session)
    assert read_shot(path) == session.facts.shot and not autosave_path(path).exists()
    keys = session.facts.shot.curves.of(LensParameter.FOCUS_DISTANCE).keys
    assert [key.value for key in keys] != [
        key.value for key in saved.curves.of(LensParameter.FOCUS_DISTANCE).keys
    ]
    session.close()


def _begin_with_an_unnamed_shot(preferences: Path, pattern: str) -> None:
    """Check that a shot without a file is kept beside its plate, and offered with it."""
    session = begin_session(preferences, pattern)
    run_until_settled(session)
    session.time.keys.set_here()
    run_until_settled(session)
    changed_shot, autosave = session.facts.shot, autosave_path(unnamed_path(preferences, pattern))
    assert autosave.exists()
    session.close()
    second_session = begin_session(preferences, pattern)
    run_until(second_session, lambda: second_session.files.documents.offer is not None, "the offer")
    second_session.files.documents.answer(recovers=True)
    assert second_session.facts.shot == changed_shot
    run_until_settled(second_session)
    second_session.close()
