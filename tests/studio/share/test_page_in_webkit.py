"""The page in WebKitGTK, the engine nearest to that of a tablet: it shows and turns the lens."""

import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from support.browser import ServeProcess
from support.patience import PATIENCE_S
from support.x_server import Screen

BROWSERS = sorted(Path("/usr/lib").glob("*/webkit2gtk-4.*/MiniBrowser"))
ENVIRONMENT = {
    "WEBKIT_DISABLE_DMABUF_RENDERER": "1",  # it waits for a GPU
    "WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS": "1",  # there is none for root; the page is ours
}

# Selenium's own class for this driver uses what Selenium has deprecated.
pytestmark = pytest.mark.filterwarnings("ignore:setting remote_server_addr:DeprecationWarning")


@pytest.fixture
def driver(monkeypatch):
    """Open WebKit's own small browser on a screen of its own; skip where it is not installed."""
    selenium = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    program = shutil.which("WebKitWebDriver")
    if not BROWSERS or not program:
        pytest.skip("Debian's package webkit2gtk-driver is not installed")
    screen = Screen()
    for name, value in (ENVIRONMENT | {"DISPLAY": screen.display}).items():
        monkeypatch.setenv(name, value)
    options = selenium.WebKitGTKOptions()
    options.binary_location = str(BROWSERS[0])
    options.add_argument("--automation")
    driver = selenium.WebKitGTK(
        options=options, service=selenium.webkitgtk.service.Service(program)
    )
    yield driver
    driver.quit()
    screen.close()


def until(condition: Callable[[], object], what: str) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, f"{what} never came"
        time.sleep(0.05)


def test_page_in_webkit_turns_the_lens_by_pointer_keys_and_wheel(driver, tmp_path):
    from selenium.webdriver.common.action_chains import ActionChains

    def focus() -> str:
        script = "return document.querySelector('#numbers b')?.textContent || ''"
        return driver.execute_script(script)

    served = ServeProcess(tmp_path, "assets/still_life.exr")
    try:
        driver.get(served.hand)
        until(focus, "the numbers")
        script = (
            "const c = document.getElementById('picture');"
            "return [...c.getContext('2d').getImageData(c.width / 3, c.height / 2, 1, 1).data]"
        )
        until(lambda: driver.execute_script(script)[:3] != [15, 15, 16], "the picture")
        for act in (
            lambda: ActionChains(driver).move_by_offset(200, 200).click().perform(),
            lambda: ActionChains(driver).send_keys("]]").perform(),
            lambda: (
                ActionChains(driver)
                .move_to_element(driver.find_element("id", "wheel"))
                .click_and_hold()
                .move_by_offset(0, -60)
                .release()
                .perform()
            ),
        ):
            before = focus()
            act()
            until(lambda before=before: focus() != before, "another focus")
    finally:
        served.stop()
