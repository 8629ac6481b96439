"""Test that a file that is no USD, or that crashes OpenUSD, raises an error of one sentence."""

import sys
from pathlib import Path

import pytest

from heatlens.core.base.errors import FaultError, InputError
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.media.camera.usd_read import read_usd_camera, usd_camera
from support.cameras import FRAMES, moving_camera
from support.usd_cameras import SUFFIXES, nested_references_stage

ENDLESS = Path(__file__).with_name("endless.usdc")
_CHANGED, _WORDS = 1088, 600  # where one byte was changed, and where its words are


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"\x89PNG\r\n\x1a\n", b'#usda 1.0\ndef Camera "a" {'])
def test_usd_camera_rejects_other_content_with_one_line_error(tmp_path, capfd, suffix, content):
    path = tmp_path / f"cam{suffix}"
    path.write_bytes(content)
    with pytest.raises(
        InputError, match="cannot be read: it is damaged or not a USD file"
    ) as refusal:
        usd_camera(str(path))
    assert len(str(refusal.value).splitlines()) == 1
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_usd_camera_rejects_truncated_file(tmp_path, suffix):
    path = tmp_path / f"cam{suffix}"
    write_camera(path, moving_camera())
    content = path.read_bytes()
    for length in range(0, len(content) - 2, len(content) // 12):
        path.write_bytes(content[:length])
        with pytest.raises(InputError, match="it is damaged or not a USD file"):
            usd_camera(str(path))


def test_usd_camera_reports_missing_file():
    with pytest.raises(InputError, match=r"none.usda is not there"):
        usd_camera("none.usda")


def test_read_camera_of_usd_runs_in_subprocess_and_returns_camera_and_errors(usd_path):
    """The subprocess passes back the camera and its errors."""
    write_camera(usd_path, moving_camera())
    assert read_camera(str(usd_path)) == usd_camera(str(usd_path))
    with pytest.raises(InputError, match="has no camera /b; it has /hero_cam"):
        read_usd_camera(f"{usd_path}:/b")


@pytest.mark.parametrize("code", [3, -11])
def test_read_usd_camera_reports_crash_of_its_subprocess(usd_path, monkeypatch, code):
    """A shell script that exits as after a crash replaces the Python executable."""
    program = usd_path.with_name("python")
    program.write_text(f"#!/bin/sh\n{'kill -SEGV $$' if code < 0 else f'exit {code}'}\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    with pytest.raises(InputError, match=r"cam.usda cannot be read: it is damaged in a way that"):
        read_usd_camera(f"{usd_path}:/cam")


def test_read_usd_camera_raises_fault_error_for_bugs_of_heatlens(
    usd_path, monkeypatch, expects_faults
):
    monkeypatch.setattr("heatlens.media.files.apart.__spec__.name", "heatlens.no_such_module")
    with pytest.raises(FaultError, match=r"No module named .*no_such_module"):
        read_usd_camera(str(usd_path))


SLIP = """#usda 1.0
(
 metersPerUnit = 1
)
def Camera "C"
{
 float focalLength = 50
 float2 xformOp:translate = (0, 5)
 uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
NUMBERS = """#usda 1.0
( metersPerUnit = 1 )
def Camera "C"
{
 %s
}
"""


@pytest.mark.parametrize(
    "content",
    [
        SLIP,
        NUMBERS % 'string focalLength = "long"',
        NUMBERS % "float3 focusDistance = (1, 2, 3)",
        NUMBERS % "token fStop = 'wide'",
        NUMBERS % "matrix3d xformOp:transform = ((1,0,0),(0,1,0),(0,0,1))\n"
        ' uniform token[] xformOpOrder = ["xformOp:transform"]',
    ],
)
def test_read_usd_camera_reports_malformed_text_in_one_line(usd_path, capfd, content):
    usd_path.write_text(content)
    with pytest.raises(InputError, match=r"cam\.usda") as refusal:
        read_usd_camera(str(usd_path))
    assert len(str(refusal.value).splitlines()) == 1 and "pxrInternal" not in str(refusal.value)
    assert capfd.readouterr() == ("", "")


def test_read_usd_camera_limits_memory(usd_path, monkeypatch):
    usd_path.write_text(nested_references_stage())
    monkeypatch.setenv("HEATLENS_READING_SECONDS", "300")
    monkeypatch.setenv("HEATLENS_READING_GIGABYTES", "1.2")
    pattern = r"cam\.usda cannot be read.* HEATLENS_READING_GIGABYTES|\(HEATLENS_READING_GIGABYTES"
    with pytest.raises(InputError, match=pattern):
        read_usd_camera(str(usd_path))


def test_read_usd_camera_limits_processor_time(monkeypatch):
    """A camera of 1,351 bytes, of which one was changed, keeps OpenUSD for 20 seconds."""
    monkeypatch.setenv("HEATLENS_READING_SECONDS", "2")
    pattern = (
        r"endless\.usdc cannot be read within 2 s of processor.* HEATLENS_READING_SECONDS allows"
    )
    with pytest.raises(InputError, match=pattern):
        read_usd_camera(str(ENDLESS))


def test_usd_camera_rejects_invalid_utf_8(tmp_path):
    path, data = tmp_path / "axis.usdc", bytearray(ENDLESS.read_bytes())
    data[_CHANGED] = 0  # as it was
    path.write_bytes(data)
    assert usd_camera(str(path)).frames
    data[data.index(b"Y", _WORDS)] = 0xD9
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"OpenUSD cannot parse it \('utf-8' codec"):
        usd_camera(str(path))


def test_read_usd_camera_does_not_import_modules_beside_the_file(usd_path, monkeypatch):
    write_camera(usd_path, moving_camera())
    usd_path.with_name("pickle.py").write_text("raise SystemExit(1)")
    monkeypatch.chdir(usd_path.parent)
    assert read_usd_camera(usd_path.name).frames == tuple(FRAMES)


def test_usd_camera_without_openusd_names_install_command(usd_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr.Usd", None)
    for use in (lambda: write_camera(usd_path, moving_camera()), lambda: usd_camera(str(usd_path))):
        with pytest.raises(InputError, match=r"Install it with: pip install 'heatlens\[usd\]'"):
            use()
    assert not usd_path.exists()
