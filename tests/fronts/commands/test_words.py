"""Test typed words: spellings of values, misspelt options, help, quiet and completion."""

import argparse
import subprocess

import pytest

from heatlens.core.base.system_packages import opengl_advice
from heatlens.fronts.commands.command_table import put_command_first
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.options.value_types import (
    parse_f_number,
    parse_millimeters,
    parse_number,
)
from heatlens.render.gpu.opengl.gl_device import _help
from support.command_line import CAMERA, channels, picture, refused_render_message, render
from support.exr_files import write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "p.exr", channels(), **CAMERA)


def message_of_refusal(capsys, *words: str) -> str:
    """Return the message of a wrong command line, which exits with code 2."""
    with pytest.raises(SystemExit) as exit_error:
        main(list(words))
    assert exit_error.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (parse_f_number, "2.8", 2.8),
        (parse_f_number, "f/2.8", 2.8),
        (parse_f_number, "F2,8", 2.8),
        (parse_f_number, "f 4", 4.0),
        (parse_f_number, "2,8", 2.8),
        (parse_f_number, "T2.8", 2.8),
        (parse_millimeters, "50", 50.0),
        (parse_millimeters, "50mm", 50.0),
        (parse_millimeters, "50 MM", 50.0),
        (parse_millimeters, "5cm", 50.0),
        (parse_millimeters, "0.05 m", 50.0),
        (parse_millimeters, "2in", 50.8),
        (parse_number, "-0,5", -0.5),
        (parse_number, "1e3", 1000.0),
    ],
)
def test_value_parsers_read_common_spellings(kind, text, value):
    assert kind(text) == pytest.approx(value)


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        *((parse_f_number, text) for text in ("wide", "f/", "2.8mm", "", "1.4-5.6", "1,400")),
        *((parse_millimeters, text) for text in ("mm", "50 km", "a", "", "1,000mm")),
        *((parse_number, text) for text in ("1,000", "1,2,3", "f/2", "960,540")),
    ],
)
def test_value_parsers_reject_text_that_is_no_number(kind, text):
    with pytest.raises(argparse.ArgumentTypeError, match="is not a number"):
        kind(text)


def test_parse_f_number_accepts_t_stop_with_warning(capsys):
    assert parse_f_number("T2.8") == 2.8
    assert "f-stop, which is a little lower" in capsys.readouterr().err


def test_render_with_typed_spellings_gives_same_picture(capsys, plate, tmp_path):
    plain_output, typed_output = tmp_path / "a.exr", tmp_path / "b.exr"
    plain = ("--f-stop", "2.8", "--focal-length", "40", "--focus-distance", "3.5")
    typed_words = ("--f-stop", "f/2,8", "--focal-length", "40mm", "--focus-distance", "3,5")
    render(capsys, plate, plain_output, *plain)
    render(capsys, plate, typed_output, *typed_words)
    assert (picture(plain_output)[1] == picture(typed_output)[1]).all()


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("render", "p.exr", "-o", "o.exr", "--fstop", "2"), "--f-stop"),
        (("render", "p.exr", "-o", "o.exr", "--aperture=2"), "--f-stop"),
        (("render", "p.exr", "-o", "o.exr", "--focal-lenght", "50"), "--focal-length"),
        (("render", "demo", "-o", "o.exr", "--camera", "dolly"), "--scene-camera"),
        (("export", "demo", "-o", "o.exr", "--camera", "dolly"), "--scene-camera"),
        (("compare", "a.exr", "b.exr", "--min-snr", "3"), "--min-psnr"),
    ],
)
def test_misspelt_option_suggests_right_one(capsys, words, meant):
    assert f"Did you mean {meant}?" in message_of_refusal(capsys, *words)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("camera", "s.heatlens.json", "-o", "c.usda", "--blades", "6"), "`heatlens shot new`"),
        (("camera", "s.heatlens.json", "-o", "c.usda", "--cat-eye=0.5"), "takes --cat-eye."),
        (("render", "p.exr", "-o", "o.exr", "--camera", "cam.json"), "`heatlens shot new` and"),
        (("render", "p.exr", "-o", "o.exr", "--lens-from=take.csv@1001"), "`heatlens view`."),
        (("render", "p.exr", "-o", "o.exr", "--fokus", "2"), "Did you mean --focus-distance?"),
        (("render", "p.exr", "-o", "o.exr", "--blende", "2"), "Did you mean --f-stop?"),
        (("--f-stop", "2", "render", "a.exr", "-o", "b.exr"), "heatlens render a.exr -o b.exr "),
    ],
)
def test_misplaced_or_foreign_option_is_explained(capsys, words, expected):
    message = message_of_refusal(capsys, *words)
    assert expected in message and "--scene-camera" not in message and "--frames" not in message


@pytest.mark.parametrize(
    ("words", "suggestion"),
    [
        (("info", "PLATE", "--depth-convention", "disparty"), "disparity"),
        (("render", "PLATE", "-o", "o.exr", "--method", "gahter"), "gather"),
        (("render", "PLATE", "-o", "o.exr", "--depth-channel", "depht.Z"), "depth.Z"),
        (("render", "PLATE", "-o", "o.exr", "--lens-kit", "vintage-prime:50"), "vintage-primes"),
        (("render", "demo", "-o", "o.exr", "--scene-camera", "dolyl"), "dolly"),
        (("shot", "new", "PLATE", "-o", "s.heatlens.json", "--key", "focsu@1=2"), "focus"),
    ],
)
def test_misspelt_value_suggests_existing_name(capsys, tmp_path, words, suggestion):
    layers = {f"depth.{name}" if name == "Z" else name: v for name, v in channels().items()}
    path = write_file(tmp_path / "p.exr", layers, **CAMERA)
    try:
        code = main([str(path) if word == "PLATE" else word for word in words])
    except SystemExit as exit_error:
        code = exit_error.code
    assert code == 2 and capsys.readouterr().err.count(f"Did you mean {suggestion}?") == 1


def test_unknown_option_without_similar_one_gets_no_suggestion(capsys):
    assert "Did you mean" not in message_of_refusal(capsys, "info", "p.exr", "--xyzzy")


@pytest.mark.parametrize(
    ("typed", "means"),
    [
        (["help", "render"], ["help", "render"]),
        (["version"], ["--version"]),
        (["-V"], ["-V"]),
        (["--quiet", "render", "p.exr"], ["render", "--quiet", "p.exr"]),
        (["-q", "p.exr"], ["view", "-q", "p.exr"]),
    ],
)
def test_put_command_first_completes_command_line(typed, means):
    assert put_command_first(typed) == means


def test_render_names_all_missing_lens_options_at_once(capsys, tmp_path):
    bare = write_file(tmp_path / "p.exr", channels())
    message = refused_render_message(capsys, bare, tmp_path / "o.exr")
    assert all(option in message for option in ("--focal-length", "--f-stop", "--focus-distance"))


def test_near_option_is_refused_for_distances(capsys, plate, tmp_path):
    message = refused_render_message(capsys, plate, tmp_path / "o.exr", "--near", "1")
    assert "leave --near out" in message


def test_error_message_has_no_view_message_before_it(capsys, tmp_path):
    message = refused_render_message(capsys, tmp_path / "nope.exr", tmp_path / "o.png")
    assert "nope.exr" in message and "seen through" not in message


def test_quiet_prints_only_results_and_errors(capsys, plate, tmp_path):
    out = tmp_path / "o.png"
    assert main(["render", str(plate), "-o", str(out), "--quiet"]) == 0
    assert capsys.readouterr() == (f"{out}\n", "")
    assert main(["-q", "info", str(tmp_path / "nope.exr")]) == 2
    assert "nope.exr" in capsys.readouterr().err
    assert "seen through" in render(capsys, plate, out)  # and is forgotten afterwards


def test_bash_completion_script_is_valid(capsys):
    with pytest.raises(SystemExit) as exit_error:
        main(["--print-completion", "bash"])
    script = capsys.readouterr().out
    assert exit_error.value.code == 0 and "--focus-distance" in script
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)


def test_gpu_help_depends_on_cause():
    assert "LIBGL_ALWAYS_SOFTWARE" in _help("eglCreateContext failed (0x3009)")
    assert opengl_advice() in _help("libEGL.so not loaded")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["help", "rendr"], "in the manual about 'rendr'. Did you mean render?"),
        (["help", "qqq"], "in the manual about 'qqq'. Try other words."),
        (["shot"], "required: new|show"),
    ],
)
def test_unknown_command_lists_or_suggests_commands(capsys, words, expected):
    code = None
    try:
        code = main(words)
    except SystemExit as end:
        code = end.code
    assert code == 2 and expected in capsys.readouterr().err
