"""What is typed as people type it: values, options of other programs, help, quiet, completion."""

import argparse
import subprocess

import pytest

from heatlens.fronts.commands.command_table import with_command
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.options.value_types import f_number, millimetres, number
from heatlens.render.gpu.opengl.gl_device import _help
from support.command_line import CAMERA, channels, picture, refused, render
from support.exr_files import write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "p.exr", channels(), **CAMERA)


def words_of(capsys, *words: str) -> str:
    """Return what a wrong command line is answered with."""
    with pytest.raises(SystemExit) as stopped:
        main(list(words))
    assert stopped.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (f_number, "2.8", 2.8),
        (f_number, "f/2.8", 2.8),
        (f_number, "F2,8", 2.8),
        (f_number, "f 4", 4.0),
        (f_number, "2,8", 2.8),
        (f_number, "T2.8", 2.8),
        (millimetres, "50", 50.0),
        (millimetres, "50mm", 50.0),
        (millimetres, "50 MM", 50.0),
        (millimetres, "5cm", 50.0),
        (millimetres, "0.05 m", 50.0),
        (millimetres, "2in", 50.8),
        (number, "-0,5", -0.5),
        (number, "1e3", 1000.0),
    ],
)
def test_values_as_people_type_them(kind, text, value):
    assert kind(text) == pytest.approx(value)


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        *((f_number, text) for text in ("wide", "f/", "2.8mm", "", "1.4-5.6", "1,400")),
        *((millimetres, text) for text in ("mm", "50 km", "a", "", "1,000mm")),
        *((number, text) for text in ("1,000", "1,2,3", "f/2", "960,540")),
    ],
)
def test_what_is_no_value_is_refused(kind, text):
    with pytest.raises(argparse.ArgumentTypeError, match="is not a number"):
        kind(text)


def test_a_t_stop_is_taken_and_said_to_be_another_number(capsys):
    assert f_number("T2.8") == 2.8
    assert "f-stop, which is a little lower" in capsys.readouterr().err


def test_all_of_them_make_the_same_picture(capsys, plate, tmp_path):
    one, other = tmp_path / "a.exr", tmp_path / "b.exr"
    plain = ("--f-stop", "2.8", "--focal-length", "40", "--focus-distance", "3.5")
    typed = ("--f-stop", "f/2,8", "--focal-length", "40mm", "--focus-distance", "3,5")
    render(capsys, plate, one, *plain)
    render(capsys, plate, other, *typed)
    assert (picture(one)[1] == picture(other)[1]).all()


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
def test_a_wrong_option_is_answered_with_the_right_one(capsys, words, meant):
    assert f"Did you mean {meant}?" in words_of(capsys, *words)


@pytest.mark.parametrize(
    ("words", "said"),
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
def test_an_option_in_the_wrong_place_is_answered_with_the_right_one(capsys, words, said):
    told = words_of(capsys, *words)
    assert said in told and "--scene-camera" not in told and "--frames" not in told


@pytest.mark.parametrize(
    ("words", "near"),
    [
        (("info", "PLATE", "--depth-convention", "disparty"), "disparity"),
        (("render", "PLATE", "-o", "o.exr", "--method", "gahter"), "gather"),
        (("render", "PLATE", "-o", "o.exr", "--depth-channel", "depht.Z"), "depth.Z"),
        (("render", "PLATE", "-o", "o.exr", "--lens-kit", "vintage-prime:50"), "vintage-primes"),
        (("render", "demo", "-o", "o.exr", "--scene-camera", "dolyl"), "dolly"),
        (("shot", "new", "PLATE", "-o", "s.heatlens.json", "--key", "focsu@1=2"), "focus"),
    ],
)
def test_a_name_like_one_there_is_is_answered_with_it(capsys, tmp_path, words, near):
    layers = {f"depth.{name}" if name == "Z" else name: v for name, v in channels().items()}
    path = write_file(tmp_path / "p.exr", layers, **CAMERA)
    try:
        code = main([str(path) if word == "PLATE" else word for word in words])
    except SystemExit as stopped:
        code = stopped.code
    assert code == 2 and capsys.readouterr().err.count(f"Did you mean {near}?") == 1


def test_an_option_like_none_is_only_called_unknown(capsys):
    assert "Did you mean" not in words_of(capsys, "info", "p.exr", "--xyzzy")


@pytest.mark.parametrize(
    ("typed", "means"),
    [
        (["help"], ["--help"]),
        (["help", "render"], ["render", "--help"]),
        (["version"], ["--version"]),
        (["-V"], ["-V"]),
        (["--quiet", "render", "p.exr"], ["render", "--quiet", "p.exr"]),
        (["-q", "p.exr"], ["view", "-q", "p.exr"]),
    ],
)
def test_words_about_the_program(typed, means):
    assert with_command(typed) == means


def test_all_values_that_are_missing_are_named_at_once(capsys, tmp_path):
    bare = write_file(tmp_path / "p.exr", channels())
    said = refused(capsys, bare, tmp_path / "o.exr")
    assert all(option in said for option in ("--focal-length", "--f-stop", "--focus-distance"))


def test_one_end_alone_is_in_vain_with_distances(capsys, plate, tmp_path):
    said = refused(capsys, plate, tmp_path / "o.exr", "--near", "1")
    assert "leave --near out" in said


def test_errors_come_without_the_view_before_them(capsys, tmp_path):
    said = refused(capsys, tmp_path / "nope.exr", tmp_path / "o.png")
    assert "nope.exr" in said and "seen through" not in said


def test_quiet_says_results_and_errors_alone(capsys, plate, tmp_path):
    out = tmp_path / "o.png"
    assert main(["render", str(plate), "-o", str(out), "--quiet"]) == 0
    assert capsys.readouterr() == (f"{out}\n", "")
    assert main(["-q", "info", str(tmp_path / "nope.exr")]) == 2
    assert "nope.exr" in capsys.readouterr().err
    assert "seen through" in render(capsys, plate, out)  # and is forgotten afterwards


def test_a_shell_takes_the_completion(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--print-completion", "bash"])
    script = capsys.readouterr().out
    assert stopped.value.code == 0 and "--focus-distance" in script
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)


def test_a_driver_that_is_too_old_is_not_to_be_installed():
    assert "LIBGL_ALWAYS_SOFTWARE" in _help("eglCreateContext failed (0x3009)")
    assert "apt-get install" in _help("libEGL.so not loaded")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["help", "rendr"], "There is no command 'rendr'. Did you mean render?"),
        (["help", "qqq"], "There is no command 'qqq'; there are view, render,"),
        (["shot"], "required: new|show"),
    ],
)
def test_what_there_is_instead_is_said(capsys, words, said):
    code = None
    try:
        code = main(words)
    except SystemExit as end:
        code = end.code
    assert code == 2 and said in capsys.readouterr().err
