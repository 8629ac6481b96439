"""A session is made of workers: all of them are polled, sleep together, and end together."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.session import Session
from heatlens.studio.session.shot.start import Start
from support.evening import begun, settled, write_plates
from support.fake_renderer import FakeRenderer


class Counted(Worker):
    """Counts what it is called for."""

    def __init__(self, wait_s=None):
        self.wait_s, self.called = wait_s, []

    def poll(self):
        self.called.append("poll")

    def seconds_until_needed(self):
        return self.wait_s

    def close(self):
        self.called.append("close")


@pytest.fixture
def session(tmp_path):
    session = begun(tmp_path / "preferences")
    yield session
    session.close()


def test_no_worker_is_left_out(session):
    """Whatever is a worker and belongs to the session is polled, however it was made."""
    desks = session, session.pictures, session.time, session.lens, session.scenes, session.files
    own = {id(v) for desk in desks for v in vars(desk).values() if isinstance(v, Worker)}
    assert len(own) > 12 and own <= {id(worker) for worker in session.workers}


def test_a_worker_more_is_polled_awaited_and_closed(session):
    late, soon = Counted(0.5), Counted(0.001)
    session.workers = (late, *session.workers, soon)
    session.poll()
    assert late.called == soon.called == ["poll"]
    assert session.seconds_until_needed() <= 0.001
    session.close()
    assert late.called == soon.called == ["poll", "close"]


def test_workers_may_be_polled_in_any_order(tmp_path):
    for number, order in enumerate((1, -1)):
        folder = tmp_path / str(number)
        folder.mkdir()
        session = begun(folder / "preferences")
        session.workers = session.workers[::order]
        session.files.commands.open(write_plates(folder))
        settled(session)
        assert session.facts.shot.source == str(folder / "walls.####.exr")
        session.close()


def test_a_session_opens_nothing_before_it_begins():
    session = Session(FakeRenderer(), Start("nothing.exr"))
    assert session.source.opener.opening is None and not session.messages.text
    session.begin()
    assert session.source.opener.opening == "nothing.exr"
    with pytest.raises(InputError):
        while True:
            session.source.arrived()
    session.close()
