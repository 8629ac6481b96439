"""A command is one record: a new one defined here works everywhere, and nothing else names it."""

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from imgui_bundle import imgui

import heatlens
from heatlens.studio.board import board
from heatlens.studio.board.command import in_group, page_command
from heatlens.studio.board.commands import named_commands
from heatlens.studio.share.shared import SharedSession
from heatlens.studio.ui.keys_window import sections
from manual_keys import key_page
from support.browser import chromium
from support.gui import gui_of
from support.session_files import QUICK, room_file

NAME, KEY, SHEET, SYNONYM = "Halve the exposure", "Ctrl+Shift+H", "Made up", "gloom"
ROW = [NAME, KEY, SHEET]
# What a page does with its table: it learns the keys, offers a button, and gives the command.
ON_THE_PAGE = """
    const [table, name, done] = arguments;
    Promise.all([import("/keys.js"), import("/more.js")]).then(([keys, more]) => {
      const sheet = document.createElement("div"), given = [];
      keys.learnKeys(table);
      new more.More(sheet, { do: (what) => given.push(what), name: "" }, {}).offer(table);
      const event = { code: "KeyH", ctrlKey: true, shiftKey: true };
      [...sheet.querySelectorAll("button")].find((it) => it.textContent === name).click();
      done([given, keys.COMMANDS[keys.chord(event)], sheet.querySelector("h2").textContent]);
    }, (error) => done(String(error)));
"""
OWN_KEYS_OF_THE_PAGE = """
    const [table, done] = arguments;
    import("/keys.js").then((keys) => {
      keys.learnKeys(table, { "Zoom in": () => 0 });
      const typed = { code: "Equal", shiftKey: true };
      done([keys.COMMANDS, keys.chord(typed), keys.chord({ ...typed, code: "KeyF" })]);
    }, (error) => done(String(error)));
"""


@pytest.fixture
def gui(ctx, tmp_path, monkeypatch):
    """Yield a window of heatlens with the new command."""

    def with_the_new_one(session, *front_end):
        view = session.pictures.commands
        new = page_command(*(NAME, partial(view.expose, -1), KEY), sheet=SHEET, synonyms=(SYNONYM,))
        return *named_commands(session, *front_end), *in_group("View", "exposure", new)

    monkeypatch.setattr(board, "named_commands", with_the_new_one)
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as found:
        yield found


@pytest.fixture
def exposure(gui):
    """Return a function that returns by how many stops the picture is brighter now."""
    return lambda: gui.session.facts.view.exposure_stops


def test_menu_key_and_palette_run_the_new_command(gui, exposure):
    gui.choose_in_menu(next(it for it in gui.screen.commands if it.name == NAME))
    by_menu = exposure()
    assert by_menu < 0.0
    gui.key(imgui.Key.h, ctrl=True, shift=True)
    assert exposure() == 2 * by_menu
    gui.key(imgui.Key.p, ctrl=True, shift=True)
    gui.frame(3)
    gui.type(SYNONYM)
    gui.key(imgui.Key.enter)
    gui.frame(3)
    assert exposure() == 3 * by_menu


def test_keys_window_and_table_of_the_manual_list_the_new_command(gui):
    rows = {
        section.title: section.rows for section in sections(gui.screen.commands, has_camera=False)
    }
    assert (KEY, NAME) in rows["View"]
    view_section = key_page(gui.screen.commands).partition("\n## View\n")[2].partition("\n## ")[0]
    assert f"| {NAME} | `{KEY}` | {SYNONYM} |" in view_section


def test_pages_get_the_new_command_and_may_give_it(gui, exposure):
    board, answers, shared = gui.screen._board, [], SharedSession()
    entries = board.json_state()
    assert ROW in entries["table"] and entries["commands"][NAME] == [None, ""]
    shared.queue_message("Ann (1)", {"do": NAME}, answers.append)
    shared.follow_messages(board)
    assert exposure() < 0.0 and answers == []


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves files and prints nothing."""

    def log_message(self, *words):
        """Say nothing."""


@pytest.fixture
def pages():
    """Yield the address at which the files of the page are served."""
    folder = Path(heatlens.__file__).parent / "studio" / "web"
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/keys.js"
    server.shutdown()
    server.server_close()


def test_page_in_a_browser_has_a_button_and_a_key_of_the_new_command(pages):
    with chromium() as browser:
        browser.driver.get(pages)
        found = browser.driver.execute_async_script(ON_THE_PAGE, [ROW], NAME)
        own_table = [["Zoom in", "J", None], ["Loupe", "Shift+D", None]]
        own = browser.driver.execute_async_script(OWN_KEYS_OF_THE_PAGE, own_table)
    assert found == [[NAME], NAME, SHEET]
    assert own == [{"J": "Zoom in"}, "+", "Shift+F"]
