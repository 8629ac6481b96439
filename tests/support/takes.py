"""A session with plates of a few frames, ready to record a pull."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from heatlens.core.model.curves.frames import Ending
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.board.session import Session
from support.evening import FIRST, LAST, begin_session, run_until_settled, write_plates


@contextmanager
def session_with_walls(folder: Path) -> Iterator[Session]:
    """Yield a session with the plates of two walls; close it afterwards."""
    session = begin_session(folder / "preferences", write_plates(folder))
    run_until_settled(session)
    yield session
    session.close()


def reset_recording(session: Session, *keyed: LensParameter, **lens: Any) -> Session:
    """Reset the session to its first frame, without a recording and without keys of `keyed`.

    `lens` replaces values of the start lens. Return the session.
    """
    session.time.recording.finish()
    session.time.recording._chosen_tolerance = None
    session.time.recording.beats = 0
    session.time.timeline.playback.stop()
    session.time.timeline.playback.ending = Ending.LOOP
    session.editing.frame = FIRST
    start_lens = session.lens.commands.start_lens.lens
    session.editing.begin(replace(session.facts.shot, lens=replace(start_lens, **lens)))
    for parameter in keyed:
        session.editing.begin(session.facts.shot.without_keys(FIRST, parameter))
    session.time.recording.poll()
    return session


def pull_focus_m(frame: float) -> float:
    """Return the focus of a pull that is even in dioptres, from 4 m to 2 m."""
    return 1.0 / (0.25 + 0.25 * (frame - FIRST) / (LAST - FIRST))
