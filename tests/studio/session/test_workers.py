"""A session is made of workers: all of them are polled, sleep together, and end together."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Worker
from heatlens.studio.board.session import Session
from heatlens.studio.settings.start import Start
from support.evening import begin_session, run_until_settled, write_plates
from support.fake_renderer import FakeRenderer


class RecordingWorker(Worker):
    """A worker that records the calls of `poll` and `close`."""

    def __init__(self, wait_s=None):
        self.wait_s, self.calls = wait_s, []

    def poll(self):
        self.calls.append("poll")

    def seconds_until_needed(self):
        return self.wait_s

    def close(self):
        self.calls.append("close")


@pytest.fixture
def session(tmp_path):
    session = begin_session(tmp_path / "preferences")
    yield session
    session.close()


def test_session_workers_include_every_worker_of_its_controls(session):
    """Each attribute of the session and its controls that is a worker is in `session.workers`."""
    controls = session, session.pictures, session.time, session.lens, session.scenes, session.files
    control_workers = {
        id(v) for control in controls for v in vars(control).values() if isinstance(v, Worker)
    }
    assert len(control_workers) > 12 and control_workers <= {
        id(worker) for worker in session.workers
    }


def test_added_worker_is_polled_waited_for_and_closed(session):
    late_worker, soon_worker = RecordingWorker(0.5), RecordingWorker(0.001)
    session.workers = (late_worker, *session.workers, soon_worker)
    session.poll()
    assert late_worker.calls == soon_worker.calls == ["poll"]
    assert session.seconds_until_needed() <= 0.001
    session.close()
    assert late_worker.calls == soon_worker.calls == ["poll", "close"]


def test_session_opens_plates_with_workers_in_any_order(tmp_path):
    for number, order in enumerate((1, -1)):
        folder = tmp_path / str(number)
        folder.mkdir()
        session = begin_session(folder / "preferences")
        session.workers = session.workers[::order]
        session.files.commands.open(write_plates(folder))
        run_until_settled(session)
        assert session.facts.shot.source == str(folder / "walls.####.exr")
        session.close()


def test_session_opens_its_source_only_after_begin():
    session = Session(FakeRenderer(), Start("nothing.exr"))
    assert session.source.opener.opening is None and not session.messages.text
    session.begin()
    assert session.source.opener.opening == "nothing.exr"
    with pytest.raises(InputError):
        while True:
            session.source.switch_source()
    session.close()
