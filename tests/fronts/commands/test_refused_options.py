"""Test that options without effect are refused with a message rather than ignored."""

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from support.command_line import (
    CAMERA,
    channels,
    message_of_refusal,
    refused_render_message,
    render,
)
from support.exports import export_shot
from support.exports import refused_export_message as refused_export
from support.exr_files import write_file

LENS = ("--f-stop", "2", "--focus-distance", "3")
TINY = ("--size", "16x9")


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


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
def test_options_that_method_ignores_are_refused(capsys, plate, tmp_path, command, words, option):
    message = message_of_refusal(capsys, command, plate, "-o", tmp_path / "o.exr", *words)
    assert f"leave {option} out" in message


def test_missing_or_black_aperture_image_is_refused(capsys, plate, tmp_path):
    words = (plate, "-o", tmp_path / "o.exr", *LENS, "--aperture-image")
    assert "no.png is not there" in message_of_refusal(
        capsys, "render", *words, tmp_path / "no.png"
    )
    Image.fromarray(np.zeros((8, 8), np.uint8)).save(tmp_path / "black.png")
    assert "black" in message_of_refusal(capsys, "render", *words, tmp_path / "black.png")
    assert not (tmp_path / "o.exr").exists()


@pytest.mark.parametrize(
    "words", [("--method", "gather"), ("--bokeh", "disc"), ("--views", "66"), ("--proxy", "0.5")]
)
@pytest.mark.parametrize("command", ["render", "export"])
def test_blur_options_are_refused_with_pinhole(capsys, tmp_path, command, words):
    arguments = ("demo", "-o", tmp_path / "o.exr", "--pinhole", *TINY, *words)
    message = message_of_refusal(capsys, command, *arguments)
    assert "without a lens" in message and f"leave {words[0]} out" in message


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
def test_plate_options_are_refused_for_scene(capsys, tmp_path, command, words):
    out = () if command == "view" else ("-o", tmp_path / "o.exr")
    message = message_of_refusal(capsys, command, "demo", *out, *words)
    assert "is a 3D scene" in message and f"leave {words[0]} out" in message


def test_shot_new_refuses_options_without_effect(capsys, plate, tmp_path):
    out = tmp_path / "s.heatlens.json"
    words = ("shot", "new", plate, "-o", out)
    assert "--bokeh" in message_of_refusal(capsys, *words, "--method", "gather", "--bokeh", "disc")
    assert "--scene-camera" in message_of_refusal(capsys, *words, "--scene-camera", "a")
    assert not out.exists()


def test_options_with_default_values_are_accepted(capsys, plate, tmp_path):
    words = ("--bokeh", "disc", "--quality", "draft", "--method", "diffusion", "--squeeze", "1")
    render(capsys, plate, tmp_path / "a.exr", *words, "--depth-convention", "auto")


def test_bench_refuses_option_that_method_ignores(capsys):
    assert "--bokeh" in message_of_refusal(capsys, "bench", "--method", "gather", "--bokeh", "disc")


@pytest.mark.parametrize("words", [("--unit", "ft"), ("--burn-in-text", "{frame}")])
def test_unit_and_burn_in_text_need_burn_in(capsys, plate, tmp_path, words):
    message = message_of_refusal(capsys, "export", plate, "-o", tmp_path / "o.png", *words)
    assert "--burn-in" in message


# Frames


@pytest.mark.parametrize("frame", [99999, 0, -5, 241])
def test_render_rejects_frame_outside_animation(capsys, tmp_path, frame):
    words = (f"--frame={frame}", *TINY)
    message = refused_render_message(capsys, "demo", tmp_path / "o.exr", *words)
    assert f"demo has frames 1 to 240, got {frame}." in message


def test_export_rejects_frames_outside_animation(capsys, tmp_path):
    message = refused_export(capsys, "demo", tmp_path / "n.####.exr", "--frames=239-242", *TINY)
    assert "1 to 240, got 241 and 1" in message


def test_export_of_static_scene_accepts_any_frame(capsys, tmp_path, small_demo):
    export_shot(capsys, "demo", tmp_path / "n.exr", "--frames=7", *TINY)  # this one stands still


def test_shot_new_notes_key_outside_animation(capsys, tmp_path):
    words = ("--key", "focus@99999=2", "--key", "focus@5=3")
    out = tmp_path / "s.heatlens.json"
    assert main(["shot", "new", "demo", "-o", str(out), *words]) == 0
    message = capsys.readouterr().err
    assert "demo has frames 1-240, with a key outside at 99999: it is kept and counts" in message


# The truth of a study


@pytest.mark.parametrize("views", [0, 4, 66, 263, 65537])
def test_study_rejects_too_few_or_too_many_views(capsys, tmp_path, views):
    words = ("study", "demo", "-o", tmp_path / "report", "--views", views)
    message = message_of_refusal(capsys, *words)
    assert "--views must be 264 to 65536" in message and f"got {views}" in message


def test_study_rejects_views_for_plate_or_with_truth(capsys, plate, tmp_path):
    words = ("study", plate, "-o", tmp_path / "report", "--views", 300)
    assert "plate.exr is a plate" in message_of_refusal(capsys, *words)
    truth = tmp_path / "light.exr"
    render(capsys, plate, truth)
    demo = ("study", "demo", "-o", tmp_path / "report", "--views", 300, "--truth", truth)
    assert "--truth is it" in message_of_refusal(capsys, *demo)
