"""Sharing from the window: its links, both hands on one lens, and the same picture on a page."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.studio.share.address import Address, Role, ShareOptions
from heatlens.studio.share.shared import REST_S
from heatlens.studio.share.sharing import squares_of
from support.share_peers import peer, until


@pytest.fixture
def gui(room_window):
    gui = room_window
    gui.begin_again()
    gui.opened()
    sharing = gui.screen.sharing.sharing
    sharing._options = ShareOptions(Address(port=0))
    yield gui
    sharing.end()


def turn(gui):
    """Do what the loop of the window does in a turn."""
    gui.screen.sharing.follow()
    gui.frame()
    gui.screen.publish()
    gui.session.work()


def test_the_menu_shows_the_links_and_a_code(gui):
    gui.do("Share with a tablet...")
    sharing = gui.screen.sharing.sharing
    gui.frame(2)
    assert sharing.is_on and "share code" in gui.drawn and "shared" in gui.drawn
    gui.click(gui.middle("copy hand"))
    assert imgui.get_clipboard_text() == sharing.link(Role.HAND)
    assert len(squares_of(sharing.link(Role.HAND))) > 20
    gui.key(imgui.Key.escape)
    gui.click(gui.middle("end sharing"))
    assert not sharing.is_on and sharing.link(Role.HAND) == ""


def test_both_hands_turn_and_the_last_touch_wins_after_a_rest(gui):
    gui.do("Share with a tablet...")
    gui.key(imgui.Key.escape)
    sharing, session = gui.screen.sharing.sharing, gui.session
    now = [100.0]
    sharing.shared.hands._clock = lambda: now[0]

    async def play():
        async with peer(sharing._server, name="Ann") as page:
            await until(lambda: page.state.get("lens"), "the state", lambda: turn(gui))
            await page.send(do="Focus", distance_m=1.25)
            await until(
                lambda: session.facts.lens.focus_distance_m == 1.25, "it", lambda: turn(gui)
            )
            lens = session.facts.lens
            gui.screen._board.change(replace(lens, focus_distance_m=1.5))
            assert session.facts.lens.focus_distance_m == 1.25
            assert "Ann (1) has the lens" in session.messages.text
            assert sharing.who() == "Shared: Ann (1)"
            now[0] += REST_S + 0.01
            gui.screen._board.change(replace(lens, focus_distance_m=1.5))
            assert session.facts.lens.focus_distance_m == 1.5
            await page.send(do="Focus", distance_m=1.75)
            await until(lambda: page.problems, "the refusal", lambda: turn(gui))
            assert page.problems == ["The window has the lens."]
            now[0] += REST_S + 0.01
            await page.send(do="Focus", distance_m=1.75)
            await until(
                lambda: session.facts.lens.focus_distance_m == 1.75, "it", lambda: turn(gui)
            )

    asyncio.run(play())


def test_the_page_gets_the_picture_of_the_window(gui):
    gui.do("Share with a tablet...")
    gui.key(imgui.Key.escape)
    sharing = gui.screen.sharing.sharing

    async def play():
        async with peer(sharing._server, width_px=4000) as page:
            await until(lambda: page.heads and page.heads[-1]["whole"], "rest", lambda: turn(gui))
            texture = gui.screen.picture.pictures.a
            shown = np.frombuffer(texture.read(), np.uint8)
            shown = shown.reshape(texture.height, texture.width, 4)[..., :3]
            np.testing.assert_array_equal(page.pixels, shown)

    asyncio.run(play())


def test_an_address_that_is_taken_is_told_in_the_window(gui):
    sharing = gui.screen.sharing.sharing
    gui.do("Share with a tablet...")
    taken = sharing._server.port
    gui.key(imgui.Key.escape)
    sharing.end()
    import socket

    with socket.create_server(("127.0.0.1", taken)):
        sharing._options = ShareOptions(Address(port=taken))
        gui.do("Share with a tablet...")
        assert not sharing.is_on and "another port" in gui.session.messages.text
