"""The page in Chromium, driven by touch: it shows the picture and turns the lens."""

import re
import threading
import time
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from PIL import Image

from heatlens.core.model.view.overlays import OVERLAYS
from heatlens.fronts.commands.main import main
from support.browser import ServeProcess, chromium
from support.evening import write_plates

PLATE = "assets/still_life.exr"
END, HOME = "\ue010", "\ue011"  # the keys of the WebDriver standard
STEP_FOCUS_NEARER, STEP_FOCUS_FARTHER = "[", "]"
SIZES = {
    "phone upright": (390, 844, 3),
    "phone lying": (844, 390, 3),
    "tablet upright": (820, 1180, 2),
    "tablet lying": (1180, 820, 2),
    "laptop": (1440, 900, 1),
    "small phone": (320, 568, 2),
    "4K": (3840, 2160, 1),
}


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def still(browser, tmp_path_factory):
    served = ServeProcess(tmp_path_factory.mktemp("still"), PLATE, "--f-stop", "1.4")
    yield served
    served.stop()


@pytest.fixture(scope="module")
def sequence(browser, tmp_path_factory):
    folder = tmp_path_factory.mktemp("walls")
    served = ServeProcess(folder, write_plates(folder))
    yield served
    served.stop()


@pytest.fixture
def page(browser, still):
    browser.size(1180, 820)
    browser.open(still.hand)
    browser.until(lambda: browser.focus and not browser.text("holder"), "the numbers")
    yield browser
    assert browser.complaints() == []


def render_pixels(tmp_path, *words):
    out = tmp_path / "render.png"
    assert main(["render", PLATE, "-o", str(out), "--f-stop", "1.4", *words]) == 0
    return np.asarray(Image.open(out).convert("RGB")).astype(int)


def test_page_picture_at_rest_equals_the_render(page, tmp_path):
    """The pixels of the canvas at 1:1 differ by at most 1 from those of `heatlens render`."""
    page.until(lambda: page.text("numbers"), "the lens")
    page.run("dispatchEvent(new KeyboardEvent('keydown', {code: 'Digit1', key: '1'}))")
    metres = re.fullmatch(r"([\d.]+) m", page.focus)[1]
    expected = render_pixels(tmp_path)
    height, width = expected.shape[:2]

    def is_same():
        shown = page.pixels().astype(int)
        rows, columns = np.nonzero((shown != (15, 15, 16)).any(-1))
        region = shown[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
        return region.shape[:2] == (height, width) and np.abs(region - expected).max() <= 1

    page.until(is_same, f"the picture of {metres} m without loss")


def test_page_tap_and_drag_focus_on_the_point_under_the_finger(page):
    before = page.focus
    _, _, x1, y1 = page.box("picture")
    page.touch([(0.2 * x1, 0.35 * y1)])
    page.until(lambda: page.focus != before, "another focus")
    tapped = page.focus
    page.touch([(0.45 * x1, 0.5 * y1)], *([(0.45 * x1 + 8 * i, 0.5 * y1)] for i in range(1, 8)))
    page.until(lambda: page.focus != tapped, "the drag")


def test_page_wheel_turns_before_the_session_answers(page):
    x0, y0, x1, y1 = page.box("wheel")
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    before = page.turned
    page.run(
        "const send = WebSocket.prototype.send;"
        "WebSocket.prototype.send = function (text) { if (!window.mute) send.call(this, text); }"
    )
    page.run("window.mute = true")
    page.touch([(x, y)], *([(x, y - 6 * i)] for i in range(1, 16)))
    page.until(lambda: page.turned != before, "the turn")
    page.run("window.mute = false")
    page.touch([(x, y)], *([(x, y + 6 * i)] for i in range(1, 10)))
    page.until(lambda: page.focus == page.turned, "the session that follows")


def picture_opacity(page) -> float:
    return float(page.run("return getComputedStyle(document.getElementById('picture')).opacity"))


def test_page_dims_a_picture_that_is_not_that_of_the_numbers(page):
    """The page withholds that pictures have arrived, so that no other one comes."""
    page.at_rest()
    page.run(
        "window.held = []; const send = WebSocket.prototype.send;"
        "WebSocket.prototype.send = function (text) {"
        "  if (!window.held || !text.includes('got')) send.call(this, text);"
        "  else window.held.push([this, text]); }"
    )
    for key in "]]":
        before = page.focus
        page.press(key)
        page.until(lambda before=before: page.focus != before, "another focus")
    page.until(lambda: page.has_class("behind") and picture_opacity(page) < 0.5, "the dimming")
    shown = "return getComputedStyle(document.getElementById('behind')).visibility"
    assert page.run(shown) == "visible" and page.text("behind") == "The picture follows"
    page.run(
        "const held = window.held; window.held = null; for (const [to, it] of held) to.send(it)"
    )
    page.until(lambda: not page.has_class("behind") and picture_opacity(page) == 1.0, "the picture")
    assert page.run(shown) == "hidden"


def test_page_has_a_button_and_a_key_for_every_overlay(page):
    buttons = "return [...document.querySelectorAll('#more button')].map((it) => it.textContent)"
    page.until(lambda: {it.words for it in OVERLAYS} <= set(page.run(buttons)), "the buttons")
    for it in OVERLAYS:
        for is_on in ("true", "false"):
            page.press(it.key.lower())
            page.until(partial(is_pressed, page, it.words, is_on), it.words)


def is_pressed(page, words, is_on):
    return page.run(
        "return [...document.querySelectorAll('#more button')]"
        ".find((it) => it.textContent === arguments[0]).ariaPressed === arguments[1]",
        *(words, is_on),
    )


def test_page_pinch_zooms_and_does_not_focus(page):
    before, picture = page.focus, page.pixels()
    pairs = [[(500 - 10 * i, 400), (600 + 10 * i, 400)] for i in range(12)]
    page.touch(*pairs)
    page.until(lambda: (page.pixels() != picture).mean() > 0.1, "a larger picture")
    assert page.focus == before


def test_page_aperture_steps_in_thirds_by_button_and_key(page):
    assert page.text("f-stop") == "f/1.4"
    page.run("document.getElementById('close').click()")
    page.until(lambda: page.text("f-stop") == "f/1.6", "a third")
    page.press("{")
    page.until(lambda: page.text("f-stop") == "f/1.4", "the key")
    before = page.focus
    page.press("]")
    page.until(lambda: page.focus != before, "the focus")


def test_page_eye_button_shows_the_pinhole_picture_while_held(page):
    before = page.at_rest()
    x0, y0, x1, y1 = page.box("eye")
    point = [{"x": (x0 + x1) / 2, "y": (y0 + y1) / 2}]
    page._send("Input.dispatchTouchEvent", type="touchStart", touchPoints=point)
    page.until(lambda: (page.pixels() != before).mean() > 0.1, "the pinhole picture")
    page._send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    page.until(lambda: np.abs(page.pixels().astype(int) - before).mean() < 1, "the lens again")


def test_page_with_look_link_cannot_turn_the_lens(page, still):
    page.open(still.look)
    page.until(lambda: page.has_class("look") and page.focus, "the look")
    before = page.focus
    page.touch([(300, 300)])
    page.press("]")
    page.until(lambda: "only for watching" in page.text("note"), "the sentence")
    assert page.focus == before
    hidden = "return [...document.querySelectorAll('.hand')].every((e) => !e.offsetParent)"
    assert page.run(hidden)


@pytest.mark.parametrize("size", [SIZES["tablet lying"], SIZES["small phone"]])
def test_page_shows_a_message_when_the_server_ends(browser, tmp_path, size):
    browser.size(*size)
    served = ServeProcess(tmp_path, PLATE)
    browser.open(served.hand)
    browser.until(lambda: browser.focus, "the numbers")
    assert not browser.run("return document.getElementById('cut').offsetParent")
    served.stop()
    browser.until(lambda: "Line lost, trying again." in browser.text("cut"), "the sentence")
    box = browser.run(
        "const b = document.getElementById('cut').getBoundingClientRect();"
        "return [b.left, b.top, b.right - innerWidth, b.bottom - innerHeight / 2]"
    )
    assert box[:3] == [0, 0, 0] and box[3] < 0, box  # across the top
    assert picture_opacity(browser) < 0.9


@pytest.mark.parametrize("size", SIZES.values(), ids=SIZES)
def test_page_controls_lie_within_every_screen_size(browser, sequence, size):
    browser.size(*size)
    browser.open(sequence.hand)
    browser.until(lambda: browser.focus and not browser.has_class("still"), "the frames")
    width, height, _ = size
    for name in ("top", "bar", "wheel", "play", "record", "show-more", "stop", "eye", "scrub"):
        x0, y0, x1, y1 = browser.box(name)
        assert x0 >= 0 and y0 >= 0 and x1 <= width + 0.5 and y1 <= height + 0.5, (name, x1, y1)
    for name in ("play", "record", "eye", "show-more", "show-looks"):
        x0, y0, x1, y1 = browser.box(name)
        assert min(x1 - x0, y1 - y0) >= 40, name
    a, b = browser.box("wheel"), browser.box("bar")
    assert a[0] >= b[2] - 0.5 or a[3] <= b[1] + 0.5
    for sheet in ("more", "looks"):
        browser.run("document.getElementById(`show-${arguments[0]}`).click()", sheet)
        x0, y0, x1, y1 = browser.box(sheet)
        assert x0 >= 0 and y0 >= 0 and x1 <= width and y1 <= height and y1 - y0 > 60, sheet
    assert browser.run("return document.documentElement.scrollWidth") <= width


def open_sequence(browser, sequence):
    """Open the page of the sequence and wait until the page before it no longer holds the lens."""
    browser.size(1180, 820)
    browser.open(sequence.hand)
    browser.until(lambda: browser.focus and not browser.has_class("still"), "the frames")
    browser.until(lambda: not browser.text("holder"), "the release by the page before")


def test_page_scrubs_and_plays_frames(browser, sequence):
    open_sequence(browser, sequence)
    browser.press(HOME)
    browser.until(lambda: browser.text("frame") == "1001", "the first frame")
    x0, y0, x1, y1 = browser.box("scrub")
    browser.touch([((x0 + x1) / 2, (y0 + y1) / 2)])
    browser.until(lambda: browser.text("frame") not in ("1001", ""), "the middle")
    browser.run("document.getElementById('play').click()")
    browser.until(lambda: browser.has_class("playing"), "the play")
    browser.run("document.getElementById('play').click()")
    browser.until(lambda: not browser.has_class("playing"), "the stop")


def tap_down_right_edge_of_wheel(browser):
    """Tap every 8 px, and so also on the flag of a mark, which lies at the edge of the wheel."""
    _, y0, x1, y1 = browser.box("wheel")
    for y in range(round(y0) + 20, round(y1) - 20, 8):
        browser.touch([(x1 - 10, y)])


def test_page_tap_on_the_flag_of_a_mark_pulls_focus_to_it(browser, sequence):
    open_sequence(browser, sequence)
    browser.press(HOME)
    browser.press("m")
    browser.until(lambda: "Mark" in browser.text("note"), "the mark")
    marked = browser.focus
    browser.press(STEP_FOCUS_NEARER * 6)
    browser.until(lambda: browser.focus != marked, "another focus")
    time.sleep(1.0)  # the wheel shows its own focus for a while after a touch
    tap_down_right_edge_of_wheel(browser)
    browser.press(END)
    browser.until(lambda: browser.focus == marked, "the mark at the end of the pull")


def test_page_reconnects_when_the_server_is_back(browser, tmp_path):
    served = ServeProcess(tmp_path, PLATE)
    browser.size(1180, 820)
    browser.open(served.hand)
    browser.until(lambda: browser.focus, "the numbers")
    browser.press(STEP_FOCUS_FARTHER * 3)
    before = browser.focus
    browser.until(lambda: browser.focus != before, "the focus")
    served.stop()
    browser.until(lambda: browser.has_class("waiting"), "the cut")
    again = ServeProcess(tmp_path, PLATE, address=f":{served.port}")
    assert again.hand == served.hand
    browser.until(lambda: not browser.has_class("waiting"), "the line")
    again.stop()


class QuietHandler(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        """Say nothing."""


def test_browser_page_of_another_origin_is_refused(browser, still, tmp_path):
    (tmp_path / "index.html").write_text("<!doctype html><title>stranger</title>")
    stranger = ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=str(tmp_path)))
    threading.Thread(target=stranger.serve_forever, daemon=True).start()
    browser.driver.get(f"http://127.0.0.1:{stranger.server_port}/")
    script = """
        const [link, done] = arguments;
        const socket = new WebSocket(link.replace("http", "ws") + "socket");
        socket.onopen = () => done("open");
        socket.onerror = () => fetch(link).then(() => done("read"), () => done("refused"));
    """
    assert browser.driver.execute_async_script(script, still.hand) == "refused"
    stranger.shutdown()
    stranger.server_close()
    browser.complaints()  # the browser says there that it was refused
