"""Test that a session draws after any message of a page, and that none ends its loop."""

import numpy as np
import pytest
from page_messages import PageSession, messages

from heatlens.render.display.screen_pictures import ScreenPictures
from support.evening import run_until_settled, session_of, write_plates

FEW, SEED = 250, 20060107


@pytest.fixture
def page_session(renderer, tmp_path):
    screen = ScreenPictures(renderer.ctx)
    session = session_of(tmp_path, renderer, screen, source=write_plates(tmp_path))
    run_until_settled(session)
    yield PageSession(session, screen)
    session.close()


def test_session_survives_random_page_messages(page_session, request):
    minutes = request.config.getoption("--fuzz-minutes")
    count = round(3000 * minutes) if minutes else FEW
    assert page_session.play(messages(count, SEED)) > count / 2
    assert page_session.refused and page_session.shared.picture is not None


@pytest.mark.parametrize(
    "wrong", [{"exposure_stops": 2000}, {"gamma": 0}, {"gamma": 1e-300}, {"exposure_stops": 1e300}]
)
def test_session_refuses_impossible_view_change(page_session, wrong):
    view_before = page_session.session.facts.view
    page_session.play(iter([{"change": "view", **wrong}]))
    assert page_session.refused == 1 and page_session.session.facts.view == view_before


def test_brighter_command_stops_at_exposure_limit(page_session):
    page_session.play(iter([{"do": "Brighter"}] * 150), turns=0)
    page_session.loop.turn()
    assert page_session.session.facts.view.exposure_stops == 30.0


def test_headless_loop_continues_after_memory_error(page_session, monkeypatch, no_fault_is_hidden):
    """The pages get a message, and the picture again when it can be drawn."""
    page_session.play(iter([{"do": "Brighter"}]))
    draw = page_session.loop._draw

    def broken():
        raise MemoryError

    monkeypatch.setattr("heatlens.studio.share.headless._ERROR_PAUSE_S", 0.0)
    monkeypatch.setattr(page_session.loop, "_draw", broken)
    page_session.play(iter([{"do": "Darker"}]))
    assert "not enough memory" in page_session.shared.state["message"]
    monkeypatch.setattr(page_session.loop, "_draw", draw)
    page_session.play(iter([{"do": "Brighter"}]), turns=5)
    assert page_session.shared.picture is not None
    assert np.isfinite(page_session.shared.picture.pixels).all()
