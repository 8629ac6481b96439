"""The command `heatlens` as a process: exit codes, and not one traceback."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

import heatlens
from heatlens import __version__
from heatlens.core.base.errors import GpuError, InputError
from heatlens.fronts.commands import info
from heatlens.fronts.commands.command_table import COMMANDS
from heatlens.fronts.commands.main import main
from support.command_line import ENVIRONMENT, started
from support.exr_files import distances, rgb, write_file

PACKAGE = Path(heatlens.__file__).parent
LIBRARIES = ["numpy", "moderngl", "OpenEXR", "PIL", "fileseq", "heatlens.core.model"]


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", rgb() | {"Z": distances()})


def refused(capsys, *words: object) -> str:
    """Return what is said on stderr of a wrong command line: short, code 2, nothing on stdout."""
    with pytest.raises(SystemExit) as stopped:
        main([str(word) for word in words])
    said = capsys.readouterr()
    assert stopped.value.code == 2
    assert said.out == "" and said.err.startswith("heatlens: ")
    assert len(said.err.splitlines()) <= 2
    return said.err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--colour", "info", "a.exr"], "--colour"),
        (["a.exr", "b.exr"], "b.exr"),
        (["render"], "plate, -o/--output"),
        (["render", "a.exr"], "-o/--output"),
        (["render", "a.exr", "-o"], "-o/--output"),
        (["render", "a.exr", "-o", "b.exr", "--bokhe", "disc"], "--bokhe"),
        (["render", "a.exr", "-o", "b.exr", "--bokeh", "star"], "'disc'"),
        (["render", "a.exr", "-o", "b.exr", "--quality", "best"], "'film'"),
        (["render", "a.exr", "-o", "b.exr", "--f-stop", "wide"], "'wide'"),
        (["render", "a.exr", "-o", "b.exr", "--layers", "2.5"], "'2.5'"),
        (["render", "a.exr", "b.exr", "-o", "c.exr"], "b.exr"),
        (["render", "a.exr", "-o", "b.exr", "--focus-at", "1,1", "--focus-distance", "2"], "not"),
        (["info"], "PLATE"),
        (["compare", "a.exr"], "TRUTH"),
    ],
)
def test_a_wrong_command_line_is_answered_in_two_lines(capsys, words, expected):
    assert expected in refused(capsys, *words)


@pytest.mark.parametrize("command", [c for c in COMMANDS if c != "shot"])  # it has two of its own
def test_a_wrong_option_points_to_the_help_of_its_command(capsys, command):
    assert f"`heatlens {command} --help` explains." in refused(capsys, command, "--no-such-thing")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(capsys, command):
    with pytest.raises(SystemExit) as stopped:
        main([command, "--help"])
    said = capsys.readouterr()
    assert stopped.value.code == 0 and said.err == ""
    assert said.out.startswith(f"usage: heatlens {command}")


@pytest.mark.parametrize(
    "words",
    [("render",), ("export",), ("view",), ("study",), ("bench",), ("shot", "new")],
    ids=" ".join,
)
def test_the_usage_of_many_options_leaves_room_for_the_sentence(capsys, words):
    with pytest.raises(SystemExit):
        main([*words, "--help"])
    usage, empty, sentence = capsys.readouterr().out.splitlines()[:3]
    assert usage.startswith(f"usage: heatlens {' '.join(words)} [options]")
    assert not empty and sentence[0].isupper()


def test_the_usage_names_what_is_needed(capsys):
    with pytest.raises(SystemExit):
        main(["render", "--help"])
    usage = "usage: heatlens render [options] -o OUTPUT plate"
    assert capsys.readouterr().out.splitlines()[0] == usage


def test_the_help_names_every_command(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert all(f" {name} {command.help} " in text for name, command in COMMANDS.items())


def test_every_module_of_a_command_is_in_the_table():
    wings = {name: command.wing for name, command in COMMANDS.items()}
    files = [path for wing in ("fronts", "lab") for path in PACKAGE.glob(f"{wing}/commands/*.py")]
    commands = [path for path in files if "\nDESCRIPTION = " in path.read_text("utf-8")]
    assert {path.stem: path.parts[-3] for path in commands} == wings


def test_the_version(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--version"])
    assert stopped.value.code == 0
    assert capsys.readouterr().out == f"heatlens {__version__}\n"


def test_ctrl_c_while_a_command_is_loaded(monkeypatch, capsys):
    def interrupted(name):
        raise KeyboardInterrupt

    monkeypatch.setattr("importlib.import_module", interrupted)
    assert main(["info", "plate.exr"]) == 130
    assert capsys.readouterr() == ("", "heatlens: stopped\n")


@pytest.mark.parametrize(
    ("word", "unloaded"),
    [
        *((word, LIBRARIES) for word in ("--version", "--help")),
        ("info", ["moderngl", "heatlens.lab.measure.study"]),
    ],
)
def test_what_is_not_asked_for_is_not_loaded(word, unloaded):
    """Else nothing could be said of Ctrl-C, and the version took half a second."""
    code = (
        "import sys\nfrom heatlens.fronts.commands.main import main\n"
        "assert 'numpy' not in sys.modules\n"
        f"try:\n    main([{word!r}, '--help'])\nexcept SystemExit:\n    pass\n"
        f"assert not set({unloaded!r}) & set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (InputError("plate.exr has no depth."), 2, "heatlens: plate.exr has no depth."),
        (GpuError("No OpenGL 4.3."), 2, "heatlens: No OpenGL 4.3."),
        (MemoryError(), 2, "not enough memory"),
        (KeyboardInterrupt(), 130, "heatlens: stopped"),
    ],
)
def test_errors_become_exit_codes(monkeypatch, capsys, error, code, words):
    def fail(args):
        raise error

    monkeypatch.setattr(info, "run", fail)
    assert main(["info", "plate.exr"]) == code
    said = capsys.readouterr()
    assert said.out == "" and words in said.err
    assert len(said.err.splitlines()) == 1


def test_python_m_heatlens_is_the_command(plate):
    process = started("info", plate)
    out, err = process.communicate()
    assert process.returncode == 0 and err == ""
    assert "8 x 6 px" in out


def test_a_missing_file_is_code_2_of_the_process(tmp_path):
    process = started("info", tmp_path / "none.exr")
    out, err = process.communicate()
    assert process.returncode == 2 and out == ""
    assert len(err.splitlines()) == 1 and "none.exr" in err


def test_nobody_reads_on(plate):
    """`heatlens info plate.exr | head -0`: the pipe is closed before anything is written."""
    reading, writing = os.pipe()
    os.close(reading)
    process = started("info", plate, stdout=writing)
    os.close(writing)
    _, err = process.communicate()
    assert err == ""
    assert process.returncode == 128 + 13


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_under_stdout_is_said(plate):
    with open("/dev/full", "w") as full:
        process = started("info", plate, stdout=full)
        _, err = process.communicate()
    assert process.returncode == 2
    assert err.splitlines() == [f"heatlens: standard output: {os.strerror(errno.ENOSPC)}"]
