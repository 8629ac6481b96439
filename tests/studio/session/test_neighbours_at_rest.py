"""What neighbouring frames show comes into the window's picture when the playhead rests."""

import threading

import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.sequence_reader import NeighbourReader
from support.dolly_plates import FIRST, write_dolly
from support.evening import session_of, settled, until


def opened(folder, pattern, **options):
    session = session_of(folder, source=pattern, plate_options=PlateOptions(**options))
    until(session, lambda: session.source.plate is not None, "the first picture")
    return session


@pytest.fixture(scope="module")
def dolly(tmp_path_factory):
    return write_dolly(tmp_path_factory.mktemp("dolly"))


def test_the_first_picture_comes_without_and_then_with(dolly, tmp_path):
    session = opened(tmp_path, dolly)
    try:
        assert session.source.plate.fragments is None
        until(session, lambda: session.source.plate.fragments is not None, "what is hidden")
        settled(session)
        session.time.timeline.go(FIRST + 3)
        until(session, lambda: session.source.plate.path.name == "dolly.0004.exr", "the frame")
        until(session, lambda: session.source.plate.fragments is not None, "what is hidden")
    finally:
        session.close()


def test_nothing_is_looked_for_if_it_is_switched_off(dolly, tmp_path):
    session = opened(tmp_path, dolly, neighbours=0)
    try:
        settled(session)
        until(session, lambda: session.source.feed._found is not None, "the end of the search")
        assert session.source.plate.fragments is None
    finally:
        session.close()


def test_one_search_runs_at_a_time_however_many_frames_a_hand_passes(dolly, tmp_path, monkeypatch):
    running, most, gate = [], [], threading.Event()
    real = NeighbourReader.found

    def slow(self, plate):
        running.append(plate)
        most.append(len(running))
        gate.wait(10)
        running.remove(plate)
        return real(self, plate)

    monkeypatch.setattr(NeighbourReader, "found", slow)
    session = opened(tmp_path, dolly)
    try:
        for frame in (FIRST + 1, FIRST + 2, FIRST + 3):
            session.time.timeline.go(frame)
            name = f"dolly.{frame:04d}.exr"
            until(session, lambda n=name: session.source.plate.path.name == n, "the frame")
        gate.set()
        until(session, lambda: session.source.plate.fragments is not None, "what is hidden")
        assert session.source.plate.path.name == "dolly.0004.exr" and max(most) == 1
    finally:
        gate.set()
        session.close()
