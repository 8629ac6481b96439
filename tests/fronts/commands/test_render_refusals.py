"""Test refusals of `heatlens render`: a message, an exit code, and no wrong picture."""

import os
import signal
import sys

import numpy as np
import pytest

from heatlens.fronts.commands.main import main
from heatlens.render.frame_renderer import FrameRenderer
from support.command_line import (
    CAMERA,
    HEIGHT,
    OLD_CONTENT,
    WIDTH,
    channels,
    depths,
    folder_of,
    picture,
    refused_render_message,
    render,
    start_heatlens,
)
from support.exr_files import rgb, write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--f-stop", "0"), "f-stop"),
        (("--f-stop", "-2"), "f-stop"),
        (("--f-stop", "nan"), "f-stop"),
        (("--f-stop", "inf"), "f-stop"),
        (("--focal-length", "0"), "focal length"),
        (("--focal-length", "nan"), "focal length"),
        (("--sensor-width", "-36"), "sensor width"),
        (("--filmback", "nonsuch"), "film back"),
        (("--filmback", ""), "film back"),
        (("--squeeze", "3"), "squeeze"),
        (("--squeeze", "nan"), "squeeze"),
        (("--focus-distance", "50mm"), "beyond the focal length"),
        (("--focus-distance", "0"), "beyond the focal length"),
        (("--focus-distance", "nan"), "not a distance"),
        (("--focus-distance", "-2"), "not a distance"),
        (("--focus-distance", ""), "not a distance"),
        (("--proxy", "0"), "proxy"),
        (("--proxy", "2"), "proxy"),
        (("--proxy", "nan"), "proxy"),
        (("--layers", "0"), "layers"),
        (("--layers", "99"), "layers"),
        (("--scene-unit", "parsec"), "parsec"),
        (("--depth-channel", "W"), "W"),
        (("--color-layer", "beauty"), "beauty"),
        (("--depth-convention", "normalized"), "--near"),
    ],
)
def test_render_rejects_impossible_options(capsys, plate, tmp_path, words, expected):
    (tmp_path / "out.exr").write_bytes(OLD_CONTENT)
    assert expected in refused_render_message(capsys, plate, tmp_path / "out.exr", *words)


def truncate_file(path, cut: int):
    path.write_bytes(path.read_bytes()[:cut])
    return path


PLATES = {
    "missing": lambda path: path,
    "a folder": lambda path: path.mkdir() or path,
    "empty": lambda path: (path.write_bytes(b"") and path) or path,
    "text": lambda path: path.write_text("not a picture") and path,
    "cut in the header": lambda path: truncate_file(write_file(path, channels(), **CAMERA), 100),
    "cut in the pixels": lambda path: truncate_file(write_file(path, channels(), **CAMERA), -30),
    "without depth": lambda path: write_file(path, rgb(HEIGHT, WIDTH), **CAMERA),
    "without colour": lambda path: write_file(path, {"Z": depths()}, **CAMERA),
    "colour mostly NaN": lambda path: write_file(
        path, channels() | {"R": np.full((HEIGHT, WIDTH), np.nan, np.float16)}, **CAMERA
    ),
    "depth of mixed sign": lambda path: write_file(
        path, channels() | {"Z": np.where(depths() > 8, -3, depths()).astype("f4")}, **CAMERA
    ),
}


@pytest.mark.parametrize("kind", PLATES)
def test_render_rejects_unusable_plate(capsys, tmp_path, kind):
    plate = PLATES[kind](tmp_path / "shot.exr")
    (tmp_path / "out.exr").write_bytes(OLD_CONTENT)
    assert "shot.exr" in refused_render_message(capsys, plate, tmp_path / "out.exr")


def test_render_rejects_impossible_outputs(capsys, plate, tmp_path):
    (tmp_path / "folder.exr").mkdir()
    for name, words in [
        ("out.bmp", ".exr, .png"),
        ("out", ".exr, .png"),
        ("none/at-all/out.exr", "no folder"),
        ("plate.exr/out.exr", "no folder"),
        ("folder.exr", "is a folder"),
    ]:
        assert words in refused_render_message(capsys, plate, tmp_path / name)
    assert not list((tmp_path / "folder.exr").iterdir())


def test_render_never_overwrites_its_plate(capsys, plate, tmp_path, monkeypatch):
    (tmp_path / "link.exr").symlink_to(plate)
    os.link(plate, tmp_path / "hard.exr")
    monkeypatch.chdir(tmp_path)
    for name in ("plate.exr", "link.exr", "hard.exr"):
        assert "the plate itself" in refused_render_message(capsys, plate, tmp_path / name)
    assert "the plate itself" in refused_render_message(
        capsys, "./plate.exr", tmp_path / "plate.exr"
    )


# Repairs


@pytest.mark.parametrize("fault", [np.nan, np.inf, -np.inf])
def test_faulty_pixels_are_repaired_with_message(capsys, tmp_path, fault):
    grey = {name: np.full((HEIGHT, WIDTH), 0.5, np.float16) for name in "RGB"}
    plain = write_file(tmp_path / "plain.exr", grey | {"Z": depths()}, **CAMERA)
    grey["G"][5, 5] = grey["R"][2, 9] = grey["B"][0, 0] = fault
    faulty = write_file(tmp_path / "faulty.exr", grey | {"Z": depths()}, **CAMERA)
    render(capsys, plain, tmp_path / "1.exr")
    message = render(capsys, faulty, tmp_path / "2.exr")
    assert f"3 of {WIDTH * HEIGHT} pixels had NaN" in message
    assert np.array_equal(picture(tmp_path / "1.exr")[1], picture(tmp_path / "2.exr")[1])


def test_faulty_depths_are_repaired_with_message(capsys, tmp_path):
    depth = depths()
    depth[4, 4] = np.nan
    plate = write_file(tmp_path / "p.exr", channels() | {"Z": depth}, **CAMERA)
    message = render(capsys, plate, tmp_path / "out.exr")
    assert f"no usable value in 1 of {WIDTH * HEIGHT} pixels" in message
    assert np.isfinite(picture(tmp_path / "out.exr")[1]).all()


# Interrupts


def test_ctrl_c_while_rendering_keeps_existing_file(capsys, plate, tmp_path, monkeypatch):
    def stopped(*_):
        raise KeyboardInterrupt

    (tmp_path / "out.exr").write_bytes(OLD_CONTENT)
    files_before = folder_of(plate)
    for owner, name in ((FrameRenderer, "steps"), (os, "replace")):
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, stopped)
            assert main(["render", str(plate), "-o", str(tmp_path / "out.exr")]) == 130
        assert capsys.readouterr().err.endswith("heatlens: stopped\n")
        assert folder_of(plate) == files_before


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent in another way there")
def test_sigint_stops_render_process_without_output(tmp_path):
    """The lens is printed before the rendering, which takes long enough to be stopped."""
    size = (1080, 1920)
    large = {name: np.full(size, 0.5, np.float16) for name in "RGB"}
    depth = np.linspace(1, 20, size[0] * size[1], dtype=np.float32).reshape(size)
    plate = write_file(tmp_path / "large.exr", large | {"Z": depth}, **CAMERA)
    process = start_heatlens("render", plate, "-o", tmp_path / "out.exr")
    depth_message, lens_message = process.stderr.readline(), process.stderr.readline()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert depth_message.startswith("heatlens: depth: Z, metres, 1 to 20")
    assert lens_message.startswith("heatlens: lens: ")
    assert (process.returncode, out, err) == (130, "", "heatlens: stopped\n")
    assert set(folder_of(plate)) == {"large.exr"}


def test_memory_error_is_reported_in_one_line(capsys, plate, tmp_path, monkeypatch):
    def too_little(*_):
        raise MemoryError

    monkeypatch.setattr(FrameRenderer, "load", too_little)
    assert main(["render", str(plate), "-o", str(tmp_path / "out.exr")]) == 2
    assert "not enough memory" in capsys.readouterr().err.splitlines()[-1]
    assert set(folder_of(plate)) == {"plate.exr"}


def test_stats_option_reports_times(capsys, plate, tmp_path):
    message = render(capsys, plate, tmp_path / "out.exr", "--stats")
    assert "read " in message and "solver " in message and "blur" in message
