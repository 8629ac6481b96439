"""A real session shared with programs that speak the protocol: the lens turns, pictures come."""

import asyncio
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from heatlens.studio.share.address import Role
from heatlens.studio.share.picture import Coding, Picture
from support import share_peers
from support.evening import session_of
from support.share_peers import peer, until

PLATE = "assets/still_life.exr"


@pytest.fixture(scope="module")
def session(renderer, tmp_path_factory):
    made = session_of(tmp_path_factory.mktemp("share"), renderer, source=PLATE)
    yield made
    made.close()


def shared(session, play):
    share_peers.with_session(session, play)


async def at_rest(peer, turn, frames=1):
    """Wait for a picture without loss of what the state tells."""
    seen = len(peer.heads)
    await until(lambda: len(peer.heads) >= seen + frames and peer.heads[-1]["whole"], "rest", turn)


def test_the_picture_at_rest_is_that_of_render(session, tmp_path):
    """Without loss: the same pixels that `heatlens render` writes to a PNG."""
    words = ["--focus-distance", "2.2", "--f-stop", "1.4"]
    assert main(["render", PLATE, "-o", str(tmp_path / "a.png"), *words]) == 0
    wanted = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)

    async def play(loop, server):
        async with peer(server, width_px=4000) as it:
            await until(lambda: it.heads, "a picture", loop.turn)
            await it.send(change="lens", focus_distance_m=2.2, f_stop=1.4)
            await until(lambda: it.state["lens"]["f_stop"] == 1.4, "the lens", loop.turn)
            await at_rest(it, loop.turn)
            assert np.abs(it.pixels.astype(int) - wanted).max() <= 1
            assert (it.state["title"], it.heads[-1]["type"]) == ("still_life.exr *", "image/png")

    shared(session, play)


def test_a_tap_focuses_and_a_drag_is_one_step_of_undo(session):
    async def play(loop, server):
        async with peer(server) as it:
            await until(lambda: it.heads, "a picture", loop.turn)
            before = it.state["lens"]["focus_distance_m"]
            await it.send(do="FocusAt", x_px=60, y_px=60)
            await until(
                lambda: it.state["lens"]["focus_distance_m"] != before, "the tap", loop.turn
            )
            await until(lambda: it.state["hand"] == "", "the hand's rest", loop.turn)
            await until(lambda: not session.editing.is_unsettled, "the tap's step", loop.turn)
            tapped = it.state["lens"]["focus_distance_m"]
            clock, now_s = session.editing.clock, session.editing.clock()
            hands = loop._shared.hands
            # A busy machine makes no rest in the gesture.
            session.editing.clock = hands._clock = lambda: now_s
            for step in range(20):
                await it.send(do="Focus", distance_m=1.5 + 0.01 * step)
                loop.turn()
            await until(lambda: it.state["lens"]["focus_distance_m"] == 1.69, "the drag", loop.turn)
            session.editing.clock, hands._clock = clock, time.monotonic
            await until(lambda: it.state["hand"] == "", "the hand's rest", loop.turn)
            await until(lambda: not session.editing.is_unsettled, "the step", loop.turn)
            await it.send(do="Undo")
            await until(
                lambda: it.state["lens"]["focus_distance_m"] == tapped, "the undo", loop.turn
            )

    shared(session, play)


def test_one_picture_is_on_its_way_and_then_the_newest(session):
    async def play(loop, server):
        async with peer(server) as it:
            it.acknowledges = False
            await until(lambda: it.heads, "a picture", loop.turn)
            for step in range(8):
                await it.send(do="Focus", distance_m=1.2 + 0.1 * step)
                for _ in range(20):
                    loop.turn()
                    await asyncio.sleep(0.002)
            assert len(it.heads) == 1
            await it.send(got=it.heads[0]["picture"])
            await until(lambda: len(it.heads) == 2, "the newest", loop.turn)
            assert it.heads[1]["picture"] > it.heads[0]["picture"]

    shared(session, play)


def test_a_looker_on_a_stalled_line_costs_the_others_nothing(session):
    async def play(loop, server):
        async with peer(server, Role.LOOK) as stalled, peer(server) as it:
            stalled.acknowledges = False
            await until(lambda: it.heads and stalled.heads, "pictures", loop.turn)
            for step in range(3):
                await it.send(do="Focus", distance_m=1.3 + 0.2 * step)
                await at_rest(it, loop.turn)
            assert len(stalled.heads) <= 2
            assert stalled.state["lens"] == it.state["lens"]

    shared(session, play)


def test_nothing_is_read_from_the_gpu_while_nobody_looks(session, monkeypatch):
    async def play(loop, server):
        loop.turn()
        monkeypatch.setattr(loop._tap._page, "now", lambda: pytest.fail("nobody looks"))
        for _ in range(20):
            loop.turn()
        monkeypatch.undo()
        async with peer(server) as it:
            await at_rest(it, loop.turn)

    shared(session, play)


def test_who_comes_back_goes_on_where_it_was(session):
    async def play(loop, server):
        async with peer(server) as it:
            await until(lambda: it.heads, "a picture", loop.turn)
            await it.send(do="Focus", distance_m=1.75)
            await until(lambda: it.state["lens"]["focus_distance_m"] == 1.75, "it", loop.turn)
        async with peer(server) as again:
            await at_rest(again, loop.turn)
            assert again.state["lens"]["focus_distance_m"] == 1.75

    shared(session, play)


def test_a_look_is_kept_with_its_still_and_overlays_are_in_the_picture(session):
    async def play(loop, server):
        async with peer(server, width_px=4000) as it:
            await at_rest(it, loop.turn)
            plain = it.pixels.astype(int)
            await it.send(do="Keep this look")
            await until(lambda: it.state["looks"], "the look", loop.turn)
            name, *_, still = it.state["looks"][0]
            assert name == "A" and len(still) > 1000
            await it.send(do="Depth")
            await at_rest(it, loop.turn)
            assert np.abs(it.pixels.astype(int) - plain).mean() > 10
            await it.send(do="Depth")
            await at_rest(it, loop.turn)
            np.testing.assert_array_equal(it.pixels, plain)

    shared(session, play)


def test_a_preview_has_the_detail_in_focus_that_the_window_draws(session):
    """A drag shows a small picture with the sharp part of the plate laid over it."""

    async def play(loop, server):
        async with peer(server, width_px=4000) as it:
            await at_rest(it, loop.turn)
            sizes = set()
            for step in range(10):
                await it.send(do="Focus", distance_m=1.2 + 0.02 * step)
                loop.turn()
                await asyncio.sleep(0.01)
                sizes |= {it.pixels.shape} if it.heads else set()
            assert sizes == {(360, 640, 3)}

    shared(session, play)


def test_the_same_picture_is_encoded_once(monkeypatch):
    picture = Picture(1, 1, np.zeros((20, 400, 4), np.uint8), False)
    one = picture.coded(Coding(1000, 80))
    assert picture.coded(Coding(400, 80)) is one
    assert picture.coded(Coding(200, 80)) is not one
    assert picture.coded(Coding(201, 80)) is picture.coded(Coding(200, 80))
    assert replace(Coding(20, 80), quality=None) != Coding(20, 80)


def test_what_the_last_work_made_is_published_before_the_loop_sleeps(session, monkeypatch):
    """A page that came during that work would otherwise hear nothing until something happens."""

    async def play(loop, server):
        await until(lambda: not session.time.scheduler.is_working, "the picture", loop.turn)
        loop.turn()
        working, drawn, draw = iter([True, True]), [], loop._draw
        is_working = property(lambda _: next(working, False))
        monkeypatch.setattr(type(session.time.scheduler), "is_working", is_working)
        monkeypatch.setattr(session, "work", lambda: None)
        monkeypatch.setattr(loop, "_draw", lambda: (drawn.append(1), draw()))
        monkeypatch.setattr(loop, "_news", SimpleNamespace(clear=bool, wait=pytest.fail))
        loop._drawn_at = float("inf")  # no pulse is due
        loop.turn()
        assert not drawn
        loop._wait()  # would fail if it slept
        loop.turn()
        assert drawn

    shared(session, play)
