"""Test the command `heatlens` as a process: exit codes and messages without tracebacks."""

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
from support.command_line import ENVIRONMENT, start_heatlens
from support.exr_files import distances, rgb, write_file

PACKAGE = Path(heatlens.__file__).parent
LIBRARIES = ["numpy", "moderngl", "OpenEXR", "PIL", "fileseq", "heatlens.core.model"]


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", rgb() | {"Z": distances()})


def message_of_refusal(capsys, *words: object) -> str:
    """Run a wrong command line, which exits with 2. Return its short message on stderr."""
    with pytest.raises(SystemExit) as exit_error:
        main([str(word) for word in words])
    captured = capsys.readouterr()
    assert exit_error.value.code == 2
    assert captured.out == "" and captured.err.startswith("heatlens: ")
    assert len(captured.err.splitlines()) <= 2
    return captured.err


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
def test_wrong_command_line_is_refused_in_at_most_two_lines(capsys, words, expected):
    assert expected in message_of_refusal(capsys, *words)


@pytest.mark.parametrize("command", [c for c in COMMANDS if c != "shot"])  # it has two of its own
def test_unknown_option_refers_to_help_of_command(capsys, command):
    assert f"`heatlens {command} --help` explains." in message_of_refusal(
        capsys, command, "--no-such-thing"
    )


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(capsys, command):
    with pytest.raises(SystemExit) as exit_error:
        main([command, "--help"])
    captured = capsys.readouterr()
    assert exit_error.value.code == 0 and captured.err == ""
    assert captured.out.startswith(f"usage: heatlens {command}")


@pytest.mark.parametrize(
    "words",
    [("render",), ("export",), ("view",), ("study",), ("bench",), ("shot", "new")],
    ids=" ".join,
)
def test_usage_of_many_options_is_shortened(capsys, words):
    with pytest.raises(SystemExit):
        main([*words, "--help"])
    usage, empty, sentence = capsys.readouterr().out.splitlines()[:3]
    assert usage.startswith(f"usage: heatlens {' '.join(words)} [options]")
    assert not empty and sentence[0].isupper()


def test_usage_names_required_arguments(capsys):
    with pytest.raises(SystemExit):
        main(["render", "--help"])
    usage = "usage: heatlens render [options] -o OUTPUT plate"
    assert capsys.readouterr().out.splitlines()[0] == usage


def test_main_help_lists_every_command(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert all(f" {name} {command.help} " in text for name, command in COMMANDS.items())


def test_every_command_module_is_in_command_table():
    wings = {name: command.wing for name, command in COMMANDS.items()}
    files = [path for wing in ("fronts", "lab") for path in PACKAGE.glob(f"{wing}/commands/*.py")]
    commands = [path for path in files if "\nDESCRIPTION = " in path.read_text("utf-8")]
    assert {path.stem: path.parts[-3] for path in commands} == wings


def test_version_option_prints_version(capsys):
    with pytest.raises(SystemExit) as exit_error:
        main(["--version"])
    assert exit_error.value.code == 0
    assert capsys.readouterr().out == f"heatlens {__version__}\n"


def test_ctrl_c_while_loading_command_exits_with_130(monkeypatch, capsys):
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
def test_help_and_version_load_no_heavy_modules(word, unloaded):
    """Without this, Ctrl-C could not be handled and `--version` took half a second."""
    code = (
        "import sys\nfrom heatlens.fronts.commands.main import main\n"
        "assert 'numpy' not in sys.modules\n"
        f"try:\n    main([{word!r}, '--help'])\nexcept SystemExit:\n    pass\n"
        f"assert not set({unloaded!r}) & set(sys.modules)"
    )
    process = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True)
    assert process.returncode == 0, process.stderr.decode()


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (InputError("plate.exr has no depth."), 2, "heatlens: plate.exr has no depth."),
        (GpuError("No OpenGL 4.3."), 2, "heatlens: No OpenGL 4.3."),
        (MemoryError(), 2, "not enough memory"),
        (KeyboardInterrupt(), 130, "heatlens: stopped"),
    ],
)
def test_exceptions_become_exit_codes_and_one_line(monkeypatch, capsys, error, code, words):
    def fail(args):
        raise error

    monkeypatch.setattr(info, "run", fail)
    assert main(["info", "plate.exr"]) == code
    captured = capsys.readouterr()
    assert captured.out == "" and words in captured.err
    assert len(captured.err.splitlines()) == 1


def test_python_m_heatlens_runs_command(plate):
    process = start_heatlens("info", plate)
    out, err = process.communicate()
    assert process.returncode == 0 and err == ""
    assert "8 x 6 px" in out


def test_missing_file_exits_with_2(tmp_path):
    process = start_heatlens("info", tmp_path / "none.exr")
    out, err = process.communicate()
    assert process.returncode == 2 and out == ""
    assert len(err.splitlines()) == 1 and "none.exr" in err


def test_closed_output_pipe_exits_with_141_silently(plate):
    """As in `heatlens info plate.exr | head -0`, the pipe is closed before anything is written."""
    reading, writing = os.pipe()
    os.close(reading)
    process = start_heatlens("info", plate, stdout=writing)
    os.close(writing)
    _, err = process.communicate()
    assert err == ""
    assert process.returncode == 128 + 13


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_under_stdout_is_reported(plate):
    with open("/dev/full", "w") as full:
        process = start_heatlens("info", plate, stdout=full)
        _, err = process.communicate()
    assert process.returncode == 2
    assert err.splitlines() == [f"heatlens: standard output: {os.strerror(errno.ENOSPC)}"]
