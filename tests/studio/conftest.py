"""Sessions without a window that tests of several folders drive."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from heatlens.studio.board.session import Session
from support.evening import begin_session, run_until_settled, write_plates


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    """Return a session that shows a sequence of two walls at 2 m and 8 m, frames 1001 to 1024."""
    session = begin_session(tmp_path / "preferences", write_plates(tmp_path))
    run_until_settled(session)
    yield session
    session.close()
