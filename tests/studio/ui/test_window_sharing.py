"""Sharing from the window: its links, the lens held by window or page, and the shared picture."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.studio.share.address import Address, Role, ShareOptions
from heatlens.studio.share.shared import REST_S
from heatlens.studio.share.sharing import qr_code_rows
from support.share_peers import connected_peer, wait_for_condition


@pytest.fixture
def gui(room_window):
    gui = room_window
    gui.begin_again()
    gui.opened()
    sharing = gui.screen.sharing.sharing
    sharing._options = ShareOptions(Address(port=0))
    yield gui
    sharing.end()


def run_loop_turn(gui):
    """Run one turn of the loop of the window."""
    gui.screen.sharing.run_requests()
    gui.frame()
    gui.screen.publish()
    gui.session.work()


def test_share_action_shows_links_and_a_code(gui):
    gui.do("Share with a tablet...")
    sharing = gui.screen.sharing.sharing
    gui.frame(2)
    assert sharing.is_on and "share code" in gui.drawn and "shared" in gui.drawn
    gui.click(gui.middle("copy hand"))
    assert imgui.get_clipboard_text() == sharing.link(Role.HAND)
    assert len(qr_code_rows(sharing.link(Role.HAND))) > 20
    gui.key(imgui.Key.escape)
    gui.click(gui.middle("end sharing"))
    assert not sharing.is_on and sharing.link(Role.HAND) == ""


def test_window_and_page_take_the_lens_only_after_the_other_rests(gui):
    gui.do("Share with a tablet...")
    gui.key(imgui.Key.escape)
    sharing, session = gui.screen.sharing.sharing, gui.session
    clock_s = [100.0]
    sharing.shared.hands._clock = lambda: clock_s[0]

    async def play():
        async with connected_peer(sharing._server, name="Ann") as page:
            await wait_for_condition(
                lambda: page.state.get("lens"), "the state", lambda: run_loop_turn(gui)
            )
            await page.send(do="Focus", distance_m=1.25)
            await wait_for_condition(
                lambda: session.facts.lens.focus_distance_m == 1.25,
                "it",
                lambda: run_loop_turn(gui),
            )
            lens = session.facts.lens
            gui.screen._board.change(replace(lens, focus_distance_m=1.5))
            assert session.facts.lens.focus_distance_m == 1.25
            assert "Ann (1) moves the lens" in session.messages.text
            assert sharing.clients_text() == "Shared: Ann (1)"
            clock_s[0] += REST_S + 0.01
            gui.screen._board.change(replace(lens, focus_distance_m=1.5))
            assert session.facts.lens.focus_distance_m == 1.5
            await page.send(do="Focus", distance_m=1.75)
            await wait_for_condition(
                lambda: page.problems, "the refusal", lambda: run_loop_turn(gui)
            )
            assert page.problems == ["The window moves the lens: wait a moment."]
            clock_s[0] += REST_S + 0.01
            await page.send(do="Focus", distance_m=1.75)
            await wait_for_condition(
                lambda: session.facts.lens.focus_distance_m == 1.75,
                "it",
                lambda: run_loop_turn(gui),
            )

    asyncio.run(play())


def test_shared_page_gets_the_picture_of_the_window(gui):
    gui.do("Share with a tablet...")
    gui.key(imgui.Key.escape)
    sharing = gui.screen.sharing.sharing

    async def play():
        async with connected_peer(sharing._server, width_px=4000) as page:
            await wait_for_condition(
                lambda: page.heads and page.heads[-1]["whole"], "rest", lambda: run_loop_turn(gui)
            )
            texture = gui.screen.picture.pictures.a
            shown = np.frombuffer(texture.read(), np.uint8)
            shown = shown.reshape(texture.height, texture.width, 4)[..., :3]
            np.testing.assert_array_equal(page.pixels, shown)

    asyncio.run(play())


def test_sharing_reports_an_address_in_use(gui):
    sharing = gui.screen.sharing.sharing
    gui.do("Share with a tablet...")
    used_port = sharing._server.port
    gui.key(imgui.Key.escape)
    sharing.end()
    import socket

    with socket.create_server(("127.0.0.1", used_port)):
        sharing._options = ShareOptions(Address(port=used_port))
        gui.do("Share with a tablet...")
        assert not sharing.is_on and "another port" in gui.session.messages.text
