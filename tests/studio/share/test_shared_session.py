"""A real session shared with clients of the protocol, which turn the lens and get pictures."""

import asyncio
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.share.address import Role
from heatlens.studio.share.picture import Coding, Picture
from support import share_peers
from support.evening import session_of
from support.share_peers import connected_peer, wait_for_condition

PLATE = "assets/still_life.exr"


@pytest.fixture(scope="module")
def screen(renderer):
    return ScreenPictures(renderer.ctx)


@pytest.fixture(scope="module")
def session(renderer, screen, tmp_path_factory):
    new_session = session_of(tmp_path_factory.mktemp("share"), renderer, screen, source=PLATE)
    yield new_session
    new_session.close()


def play_with_session(session, screen, play):
    share_peers.with_session(session, screen, play)


async def wait_for_whole_picture(peer, turn, frames=1):
    """Wait until the peer got `frames` more pictures and the last one is whole and lossless."""
    count_before = len(peer.heads)
    await wait_for_condition(
        lambda: len(peer.heads) >= count_before + frames and peer.heads[-1]["whole"], "rest", turn
    )


def test_shared_picture_at_rest_equals_the_render(session, screen, tmp_path):
    """The lossless picture has the pixels of `heatlens render` within 1 of 255."""
    words = ["--focus-distance", "2.2", "--f-stop", "1.4"]
    assert main(["render", PLATE, "-o", str(tmp_path / "a.png"), *words]) == 0
    expected = np.asarray(Image.open(tmp_path / "a.png").convert("RGB")).astype(int)

    async def play(loop, server):
        async with connected_peer(server, width_px=4000) as it:
            await wait_for_condition(lambda: it.heads, "a picture", loop.turn)
            await it.send(change="lens", focus_distance_m=2.2, f_stop=1.4)
            await wait_for_condition(
                lambda: it.state["lens"]["f_stop"] == 1.4, "the lens", loop.turn
            )
            await wait_for_whole_picture(it, loop.turn)
            assert np.abs(it.pixels.astype(int) - expected).max() <= 1
            assert (it.state["title"], it.heads[-1]["type"]) == ("still_life.exr *", "image/png")

    play_with_session(session, screen, play)


def test_peer_tap_focuses_and_drag_is_one_undo_step(session, screen):
    async def play(loop, server):
        async with connected_peer(server) as it:
            await wait_for_condition(lambda: it.heads, "a picture", loop.turn)
            before = it.state["lens"]["focus_distance_m"]
            await it.send(do="FocusAt", x_px=60, y_px=60)
            await wait_for_condition(
                lambda: it.state["lens"]["focus_distance_m"] != before, "the tap", loop.turn
            )
            await wait_for_condition(lambda: it.state["hand"] == "", "the hand's rest", loop.turn)
            await wait_for_condition(
                lambda: not session.editing.is_unsettled, "the tap's step", loop.turn
            )
            tapped = it.state["lens"]["focus_distance_m"]
            clock, now_s = session.editing.clock, session.editing.clock()
            hands = loop._shared.hands
            # A busy machine makes no rest in the gesture.
            session.editing.clock = hands._clock = lambda: now_s
            for step in range(20):
                await it.send(do="Focus", distance_m=1.5 + 0.01 * step)
                loop.turn()
            await wait_for_condition(
                lambda: it.state["lens"]["focus_distance_m"] == 1.69, "the drag", loop.turn
            )
            session.editing.clock, hands._clock = clock, time.monotonic
            await wait_for_condition(lambda: it.state["hand"] == "", "the hand's rest", loop.turn)
            await wait_for_condition(
                lambda: not session.editing.is_unsettled, "the step", loop.turn
            )
            await it.send(do="Undo")
            await wait_for_condition(
                lambda: it.state["lens"]["focus_distance_m"] == tapped, "the undo", loop.turn
            )

    play_with_session(session, screen, play)


def test_peer_gets_the_newest_picture_after_each_acknowledgment(session, screen):
    async def play(loop, server):
        async with connected_peer(server) as it:
            it.acknowledges = False
            await wait_for_condition(lambda: it.heads, "a picture", loop.turn)
            for step in range(8):
                await it.send(do="Focus", distance_m=1.2 + 0.1 * step)
                for _ in range(20):
                    loop.turn()
                    await asyncio.sleep(0.002)
            assert len(it.heads) == 1
            await it.send(got=it.heads[0]["picture"])
            await wait_for_condition(lambda: len(it.heads) == 2, "the newest", loop.turn)
            assert it.heads[1]["picture"] > it.heads[0]["picture"]

    play_with_session(session, screen, play)


def test_stalled_peer_does_not_delay_other_peers(session, screen):
    async def play(loop, server):
        async with connected_peer(server, Role.LOOK) as stalled, connected_peer(server) as it:
            stalled.acknowledges = False
            await wait_for_condition(lambda: it.heads and stalled.heads, "pictures", loop.turn)
            for step in range(3):
                await it.send(do="Focus", distance_m=1.3 + 0.2 * step)
                await wait_for_whole_picture(it, loop.turn)
            assert len(stalled.heads) <= 2
            assert stalled.state["lens"] == it.state["lens"]

    play_with_session(session, screen, play)


def test_no_picture_is_read_from_the_gpu_without_peers(session, screen, monkeypatch):
    async def play(loop, server):
        loop.turn()
        monkeypatch.setattr(loop.board, "json_state", lambda: pytest.fail("nobody looks"))
        for _ in range(20):
            loop.turn()
        monkeypatch.undo()
        async with connected_peer(server) as it:
            await wait_for_whole_picture(it, loop.turn)

    play_with_session(session, screen, play)


def test_reconnected_peer_gets_the_state_of_the_session(session, screen):
    async def play(loop, server):
        async with connected_peer(server) as it:
            await wait_for_condition(lambda: it.heads, "a picture", loop.turn)
            await it.send(do="Focus", distance_m=1.75)
            await wait_for_condition(
                lambda: it.state["lens"]["focus_distance_m"] == 1.75, "it", loop.turn
            )
        async with connected_peer(server) as again:
            await wait_for_whole_picture(again, loop.turn)
            assert again.state["lens"]["focus_distance_m"] == 1.75

    play_with_session(session, screen, play)


def test_peer_keeps_a_look_with_its_still_and_sees_overlays(session, screen):
    async def play(loop, server):
        async with connected_peer(server, width_px=4000) as it:
            await wait_for_whole_picture(it, loop.turn)
            plain = it.pixels.astype(int)
            await it.send(do="Keep this look")
            await wait_for_condition(lambda: it.state["looks"], "the look", loop.turn)
            name, *_, still = it.state["looks"][0]
            assert name == "A" and len(still) > 1000
            await it.send(do="Depth")
            # Until then, the plain picture may come once more: its shot has another look.
            await wait_for_condition(
                lambda: it.state["view"]["overlay"] == "depth", "the overlay", loop.turn
            )
            await wait_for_whole_picture(it, loop.turn)
            assert np.abs(it.pixels.astype(int) - plain).mean() > 10
            await it.send(do="Depth")
            await wait_for_whole_picture(it, loop.turn)
            np.testing.assert_array_equal(it.pixels, plain)

    play_with_session(session, screen, play)


def test_shared_preview_has_the_full_size_during_a_drag(session, screen):
    """During a drag a small picture is sent with the sharp region of the plate drawn over it."""

    async def play(loop, server):
        async with connected_peer(server, width_px=4000) as it:
            await wait_for_whole_picture(it, loop.turn)
            sizes = set()
            for step in range(10):
                await it.send(do="Focus", distance_m=1.2 + 0.02 * step)
                loop.turn()
                await asyncio.sleep(0.01)
                sizes |= {it.pixels.shape} if it.heads else set()
            assert sizes == {(360, 640, 3)}

    play_with_session(session, screen, play)


def test_picture_is_encoded_once_per_size_and_quality(monkeypatch):
    picture = Picture(1, 1, np.zeros((20, 400, 4), np.uint8), False)
    coded = picture.encode(Coding(1000, 80))
    assert picture.encode(Coding(400, 80)) is coded
    assert picture.encode(Coding(200, 80)) is not coded
    assert picture.encode(Coding(201, 80)) is picture.encode(Coding(200, 80))
    assert replace(Coding(20, 80), quality=None) != Coding(20, 80)


def test_loop_publishes_the_last_work_before_it_sleeps(session, screen, monkeypatch):
    """Without this, a page that connects during that work gets nothing until the next event."""

    async def play(loop, server):
        await wait_for_condition(
            lambda: not session.time.scheduler.is_working, "the picture", loop.turn
        )
        loop.turn()
        pieces, draw_calls, draw = [1], [], loop._draw  # one piece of work, which shows nothing new
        is_working = property(lambda _: bool(pieces))
        monkeypatch.setattr(type(session.time.scheduler), "is_working", is_working)
        monkeypatch.setattr(session, "work", pieces.clear)
        monkeypatch.setattr(loop, "_draw", lambda: (draw_calls.append(1), draw()))
        monkeypatch.setattr(loop, "_wake_event", SimpleNamespace(clear=bool, wait=pytest.fail))
        loop._loop_turn._drawn_s = float("inf")  # no pulse is due
        loop.turn()
        assert not draw_calls and not pieces
        loop._wait()  # would fail if it slept
        loop.turn()
        assert draw_calls

    play_with_session(session, screen, play)
