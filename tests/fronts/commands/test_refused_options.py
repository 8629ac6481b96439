"""What would change nothing is refused in a sentence, rather than left out in silence."""

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels, refused, render
from support.exports import exported
from support.exports import refused as refused_export
from support.exr_files import write_file

LENS = ("--f-stop", "2", "--focus-distance", "3")
TINY = ("--size", "16x9")


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


def said_of(capsys, *words: object) -> str:
    """Return the one line on stderr of what is refused."""
    assert main([str(word) for word in words]) == 2
    said = capsys.readouterr()
    assert said.out == "" and len(said.err.splitlines()) == 1
    return said.err


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (("--method", "gather", "--bokeh", "disc"), "--bokeh"),
        (("--method", "heat", "--quality", "film"), "--quality"),
        (("--method", "pyramid", "--layers", "3"), "--layers"),
        (("--views", "12"), "--views"),
        (("--method", "scatter", "--views", "66"), "--views"),
    ],
)
@pytest.mark.parametrize("command", ["render", "export"])
def test_a_choice_that_a_method_does_not_have(capsys, plate, tmp_path, command, words, option):
    said = said_of(capsys, command, plate, "-o", tmp_path / "o.exr", *words)
    assert f"leave {option} out" in said


def test_an_image_that_cannot_be_an_opening(capsys, plate, tmp_path):
    given = (plate, "-o", tmp_path / "o.exr", *LENS, "--aperture-image")
    assert "no.png is not there" in said_of(capsys, "render", *given, tmp_path / "no.png")
    Image.fromarray(np.zeros((8, 8), np.uint8)).save(tmp_path / "black.png")
    assert "black" in said_of(capsys, "render", *given, tmp_path / "black.png")
    assert not (tmp_path / "o.exr").exists()


@pytest.mark.parametrize(
    "words",
    [("--method", "gather"), ("--bokeh", "disc"), ("--views", "66"), ("--proxy", "0.5")],
)
@pytest.mark.parametrize("command", ["render", "export"])
def test_without_a_lens_there_is_no_blur(capsys, tmp_path, command, words):
    given = ("demo", "-o", tmp_path / "o.exr", "--pinhole", *TINY, *words)
    said = said_of(capsys, command, *given)
    assert "without a lens" in said and f"leave {words[0]} out" in said


@pytest.mark.parametrize(
    "words",
    [
        ("--depth-convention", "auto"),
        ("--depth-kind", "planar"),
        ("--scene-unit", "m"),
        ("--depth-channel", "Z"),
        ("--near", "1"),
    ],
)
@pytest.mark.parametrize("command", ["render", "export", "study", "view"])
def test_a_scene_is_not_read_as_a_plate(capsys, tmp_path, command, words):
    out = () if command == "view" else ("-o", tmp_path / "o.exr")
    said = said_of(capsys, command, "demo", *out, *words)
    assert "is a 3D scene" in said and f"leave {words[0]} out" in said


def test_a_shot_is_not_written_with_what_it_cannot_follow(capsys, plate, tmp_path):
    out = tmp_path / "s.heatlens.json"
    words = ("shot", "new", plate, "-o", out)
    assert "--bokeh" in said_of(capsys, *words, "--method", "gather", "--bokeh", "disc")
    assert "--scene-camera" in said_of(capsys, *words, "--scene-camera", "a")
    assert not out.exists()


def test_what_is_at_its_default_may_be_said_where_it_counts(capsys, plate, tmp_path):
    words = ("--bokeh", "disc", "--quality", "draft", "--method", "diffusion", "--squeeze", "1")
    render(capsys, plate, tmp_path / "a.exr", *words, "--depth-convention", "auto")


def test_bench_measures_one_method_or_all(capsys):
    assert "--bokeh" in said_of(capsys, "bench", "--method", "gather", "--bokeh", "disc")


@pytest.mark.parametrize("words", [("--unit", "ft"), ("--burn-in-text", "{frame}")])
def test_a_unit_and_a_text_go_with_the_burn_in(capsys, plate, tmp_path, words):
    said = said_of(capsys, "export", plate, "-o", tmp_path / "o.png", *words)
    assert "--burn-in" in said


# Frames


@pytest.mark.parametrize("frame", [99999, 0, -5, 241])
def test_a_frame_outside_the_animation(capsys, tmp_path, frame):
    words = (f"--frame={frame}", *TINY)
    said = refused(capsys, "demo", tmp_path / "o.exr", *words)
    assert f"demo has frames 1 to 240, got {frame}." in said


def test_frames_outside_the_animation_are_not_exported(capsys, tmp_path):
    said = refused_export(capsys, "demo", tmp_path / "n.####.exr", "--frames=239-242", *TINY)
    assert "1 to 240, got 241 and 1" in said


def test_the_last_frame_is_one_of_them(capsys, tmp_path, small_demo):
    exported(capsys, "demo", tmp_path / "n.exr", "--frames=7", *TINY)  # this one stands still


def test_a_key_outside_is_noted(capsys, tmp_path):
    words = ("--key", "focus@99999=2", "--key", "focus@5=3")
    out = tmp_path / "s.heatlens.json"
    assert main(["shot", "new", "demo", "-o", str(out), *words]) == 0
    said = capsys.readouterr().err
    assert "demo has frames 1-240, with a key outside at 99999: it is kept and counts" in said


# The truth of a study


@pytest.mark.parametrize("views", [0, 4, 66, 263, 65537])
def test_a_truth_is_finer_than_what_it_judges(capsys, tmp_path, views):
    words = ("study", "demo", "-o", tmp_path / "report", "--views", views)
    said = said_of(capsys, *words)
    assert "--views must be 264 to 65536" in said and f"got {views}" in said


def test_only_a_scene_has_such_a_truth(capsys, plate, tmp_path):
    words = ("study", plate, "-o", tmp_path / "report", "--views", 300)
    assert "plate.exr is a plate" in said_of(capsys, *words)
    truth = tmp_path / "light.exr"
    render(capsys, plate, truth)
    demo = ("study", "demo", "-o", tmp_path / "report", "--views", 300, "--truth", truth)
    assert "--truth is it" in said_of(capsys, *demo)
