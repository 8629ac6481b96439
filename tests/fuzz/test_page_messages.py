"""Messages of pages are followed and drawn, whatever their values; none ends the loop."""

import numpy as np
import pytest
from page_messages import Played, messages

from support.evening import session_of, settled, write_plates

FEW, SEED = 250, 20060107


@pytest.fixture
def played(renderer, tmp_path):
    session = session_of(tmp_path, renderer, source=write_plates(tmp_path))
    settled(session)
    yield Played(session)
    session.close()


def test_messages_are_drawn(played, request):
    minutes = request.config.getoption("--fuzz-minutes")
    count = round(3000 * minutes) if minutes else FEW
    assert played.play(messages(count, SEED)) > count / 2
    assert played.refused and played.shared.picture is not None


@pytest.mark.parametrize(
    "wrong", [{"exposure_stops": 2000}, {"gamma": 0}, {"gamma": 1e-300}, {"exposure_stops": 1e300}]
)
def test_a_view_that_cannot_be_drawn_is_refused(played, wrong):
    before = played.session.facts.view
    played.play(iter([{"change": "view", **wrong}]))
    assert played.refused == 1 and played.session.facts.view == before


def test_brighter_ends_at_the_limit_of_the_exposure(played):
    played.play(iter([{"do": "Brighter"}] * 150), turns=0)
    played.loop.turn()
    assert played.session.facts.view.exposure_stops == 30.0


def test_the_loop_goes_on_after_what_cannot_be_drawn(played, monkeypatch, no_fault_is_hidden):
    """The pages are told, and see the picture again once it can be drawn."""
    played.play(iter([{"do": "Brighter"}]))
    draw = played.loop._draw

    def broken():
        raise MemoryError

    monkeypatch.setattr("heatlens.studio.share.headless._AFTER_ERROR_S", 0.0)
    monkeypatch.setattr(played.loop, "_draw", broken)
    played.play(iter([{"do": "Darker"}]))
    assert "not enough memory" in played.shared.state["message"]
    monkeypatch.setattr(played.loop, "_draw", draw)
    played.play(iter([{"do": "Brighter"}]), turns=5)
    assert played.shared.picture is not None
    assert np.isfinite(played.shared.picture.pixels).all()
