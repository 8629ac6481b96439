"""Debian's Chromium with simulated touch, and the `heatlens serve` process whose page it opens."""

import base64
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from support.command_line import ENVIRONMENT
from support.patience import PATIENCE_S


class ServeProcess:
    """`heatlens serve` in a process of its own."""

    def __init__(self, folder: Path, *words: object, address: str = ":0") -> None:
        environment = ENVIRONMENT | {"HEATLENS_CONFIG_DIR": str(folder)}
        command = [sys.executable, "-m", "heatlens", "serve", *map(str, words)]
        self._process = subprocess.Popen(
            [*command, "--address", address],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
        )
        assert self._process.stdout is not None
        self.hand, self.look = (self._link() for _ in range(2))
        self.port = int(re.search(r":(\d+)/", self.hand)[1])

    def _link(self) -> str:
        match = re.search(r"http\S+", self._process.stdout.readline())
        assert match is not None, self._process.stderr.read()
        return match[0]

    def stop(self) -> None:
        """End the process by SIGINT, as Ctrl-C does."""
        self._process.send_signal(signal.SIGINT)
        self._process.communicate(timeout=PATIENCE_S)


class Browser:
    """A page in Chromium, with touch."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def size(self, width: int, height: int, ratio: float = 1.0, has_touch: bool = True) -> None:
        """Show the page as on a device of this size."""
        self._send(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=ratio,
            mobile=has_touch,
        )
        self._send("Emulation.setTouchEmulationEnabled", enabled=has_touch, maxTouchPoints=5)

    def _send(self, name: str, **values: object) -> Any:
        return self.driver.execute_cdp_cmd(name, values)

    def open(self, link: str) -> None:
        self.driver.get(link)
        self.until(lambda: not self.has_class("waiting"), "the line")

    def run(self, script: str, *values: object) -> Any:
        """Run JavaScript in the page; return what it returns."""
        return self.driver.execute_script(script, *values)

    def text(self, name: str) -> str:
        return self.run("return document.getElementById(arguments[0]).textContent", name)

    def has_class(self, name: str) -> bool:
        return self.run("return document.body.classList.contains(arguments[0])", name)

    def box(self, name: str) -> tuple[float, float, float, float]:
        """Return x0, y0, x1, y1 of an element."""
        script = "const b = document.getElementById(arguments[0]).getBoundingClientRect();"
        return tuple(self.run(f"{script} return [b.left, b.top, b.right, b.bottom]", name))

    @property
    def focus(self) -> str:
        """The focus distance as the page shows it in numbers."""
        return self.run("return document.querySelector('#numbers b')?.textContent || ''")

    @property
    def turned(self) -> str:
        """The focus distance that the wheel shows."""
        return self.run("return document.getElementById('wheel').getAttribute('aria-valuetext')")

    def touch(self, *steps: list[tuple[float, float]]) -> None:
        """Put fingers down at the first points, move them over the others, and lift them."""
        for index, points in enumerate(steps):
            fingers = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
            kind = "touchMove" if index else "touchStart"
            self._send("Input.dispatchTouchEvent", type=kind, touchPoints=fingers)
        self._send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def press(self, keys: str) -> None:
        from selenium.webdriver.common.action_chains import ActionChains

        ActionChains(self.driver).send_keys(keys).perform()

    def pixels(self) -> np.ndarray:
        """Return what the canvas of the picture holds, (H, W, 3)."""
        url = self.run("return document.getElementById('picture').toDataURL('image/png')")
        data = base64.b64decode(url.partition(",")[2])
        return np.asarray(Image.open(BytesIO(data)).convert("RGB"))

    def at_rest(self) -> np.ndarray:
        """Wait until the whole picture is shown and no longer changes. Return its pixels."""
        pictures = [np.zeros(0)]

        def stands() -> bool:
            if self.run("return document.getElementById('picture').ariaBusy") != "false":
                return False
            pictures.append(self.pixels())
            time.sleep(0.7)
            return pictures[-1].std() > 5 and np.array_equal(pictures[-1], self.pixels())

        self.until(stands, "a picture that stands")
        return pictures[-1]

    def until(self, condition: Callable[[], object], label: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, f"{label} never came; {self.complaints()}"
            time.sleep(0.02)

    def complaints(self) -> list[str]:
        """Return the errors and warnings of the console."""
        return [entry["message"] for entry in self.driver.get_log("browser")]


@contextmanager
def chromium() -> Iterator[Browser]:
    """Open Debian's Chromium without a screen; skip where it is not installed."""
    selenium = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not binary or not driver:
        pytest.skip("Debian's packages chromium and chromium-driver are not installed")
    options = selenium.ChromeOptions()
    options.binary_location = binary
    root = ["--no-sandbox"] if hasattr(os, "getuid") and os.getuid() == 0 else []
    for word in ("--headless=new", "--disable-gpu", "--force-color-profile=srgb", *root):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver_session = selenium.Chrome(options=options, service=selenium.ChromeService(driver))
    try:
        yield Browser(driver_session)
    finally:
        driver_session.quit()
