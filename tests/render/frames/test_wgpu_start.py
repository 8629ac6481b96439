"""How a process begins to draw by wgpu."""

import subprocess
import sys
from pathlib import Path

from support.command_line import ENVIRONMENT

_START = """
import sys
from heatlens.render.gpu.wgpu.wgpu_device import headless_device
content = headless_device().buffer(b"12345678").read()
print("cffi.recompiler" in sys.modules, content)
"""


def start(cache: Path) -> str:
    """Make a device and use it in a new process. Return whether a header was parsed, and bytes."""
    environment = ENVIRONMENT | {"HEATLENS_CACHE_DIR": str(cache)}
    words = [sys.executable, "-c", _START]
    run = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    return run.stdout


def test_header_of_wgpu_is_parsed_once_and_again_where_kept_result_is_damaged(tmp_path):
    assert start(tmp_path) == "True b'12345678'\n"
    (kept,) = tmp_path.glob("shaders/*.cffi")
    assert start(tmp_path) == "False b'12345678'\n"
    for damage in (b"{'_types': 1}", b"{"):
        kept.write_bytes(damage)
        assert start(tmp_path) == "True b'12345678'\n"


def test_wgpu_starts_where_its_cache_folder_cannot_be_written(tmp_path):
    (tmp_path / "shaders").write_bytes(b"a file")
    assert start(tmp_path) == "True b'12345678'\n"
