"""Hidden surfaces that neighboring frames show are added to the picture at rest."""

import threading

import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.neighbour_reader import NeighbourReader
from support.dolly_plates import FIRST, write_dolly
from support.evening import run_until, run_until_settled, session_of


def open_session(folder, pattern, **options):
    session = session_of(folder, source=pattern, plate_options=PlateOptions(**options))
    run_until(session, lambda: session.source.plate is not None, "the first picture")
    return session


@pytest.fixture(scope="module")
def dolly(tmp_path_factory):
    return write_dolly(tmp_path_factory.mktemp("dolly"))


def test_first_picture_gets_hidden_surfaces_from_neighbors_later(dolly, tmp_path):
    session = open_session(tmp_path, dolly)
    try:
        assert session.source.plate.fragments is None
        run_until(session, lambda: session.source.plate.fragments is not None, "what is hidden")
        run_until_settled(session)
        session.time.timeline.go_to(FIRST + 3)
        run_until(session, lambda: session.source.plate.path.name == "dolly.0004.exr", "the frame")
        run_until(session, lambda: session.source.plate.fragments is not None, "what is hidden")
    finally:
        session.close()


def wait_for_search_end(session) -> None:
    """Wait until the neighboring frames were searched for hidden surfaces."""
    feed = session.source.feed
    run_until(session, lambda: feed._searched_pair is not None, "the end of the search")


def test_zero_neighboring_frames_add_no_hidden_surfaces(dolly, tmp_path):
    session = open_session(tmp_path, dolly, neighbours=0)
    try:
        run_until_settled(session)
        wait_for_search_end(session)
        assert session.source.plate.fragments is None
    finally:
        session.close()


def test_only_one_neighbor_search_runs_while_playhead_moves(dolly, tmp_path, monkeypatch):
    running, running_counts, gate = [], [], threading.Event()
    add_hidden_surfaces = NeighbourReader.add_hidden_surfaces

    def add_slowly(self, plate):
        running.append(plate)
        running_counts.append(len(running))
        gate.wait(10)
        running.remove(plate)
        return add_hidden_surfaces(self, plate)

    monkeypatch.setattr(NeighbourReader, "add_hidden_surfaces", add_slowly)
    session = open_session(tmp_path, dolly)
    try:
        for frame in (FIRST + 1, FIRST + 2, FIRST + 3):
            session.time.timeline.go_to(frame)
            name = f"dolly.{frame:04d}.exr"
            run_until(session, lambda n=name: session.source.plate.path.name == n, "the frame")
        gate.set()
        run_until(session, lambda: session.source.plate.fragments is not None, "what is hidden")
        assert session.source.plate.path.name == "dolly.0004.exr" and max(running_counts) == 1
    finally:
        gate.set()
        session.close()
