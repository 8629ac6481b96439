"""The example client in the manual runs unchanged against `heatlens serve`."""

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from support.browser import ServeProcess
from support.manual import page


def test_client_of_the_manual_pulls_focus_and_saves_pictures(tmp_path):
    (code,) = re.findall(r"```python\n(.*?)```", page("protocol"), re.DOTALL)
    (tmp_path / "client.py").write_text(code)
    plate = Path("assets/still_life.exr").absolute()
    served = ServeProcess(tmp_path / "own", plate, "--quality", "draft", "--bokeh", "heat")
    try:
        run = subprocess.run(
            [sys.executable, "client.py", served.hand],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=200,
        )
    finally:
        served.stop()
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    pictures = [np.asarray(Image.open(tmp_path / f"focus_{m}m.png")) for m in ("1.2", "2", "4")]
    assert {picture.shape for picture in pictures} == {(360, 640, 3)}
    assert all((a != b).mean() > 0.1 for a, b in pairwise(pictures))
