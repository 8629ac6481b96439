"""Test the log: `--verbose` prints what is behind a message, HEATLENS_LOG keeps all of it."""

import os
import pickle

import pytest

from heatlens.core.base.log import FILE_VARIABLE
from heatlens.core.base.messages import Explained
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels, render
from support.exr_files import write_file


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", channels(), **CAMERA)


def test_verbose_prints_reasons_device_and_times(capsys, plate, tmp_path):
    plain = render(capsys, plate, tmp_path / "a.exr").splitlines()
    verbose = render(capsys, plate, tmp_path / "b.exr", "--verbose")
    assert set(plain) < set(verbose.splitlines())
    for words in ("so they are distances.", "(header, aperture)", "read ", "ended with 0 after"):
        assert words in verbose and words not in "\n".join(plain)
    assert render(capsys, plate, tmp_path / "c.exr").splitlines() == plain


def test_log_file_gets_messages_details_and_refusals(capsys, plate, tmp_path, monkeypatch):
    log = tmp_path / "a.log"
    monkeypatch.setenv(FILE_VARIABLE, str(log))
    message = render(capsys, plate, tmp_path / "out.exr", "--quiet")
    assert message == ""
    render(capsys, plate, tmp_path / "out.exr")
    assert main(["render", str(plate), "-o", str(tmp_path / "o.xyz")]) == 2
    lines = log.read_text(encoding="utf-8").splitlines()
    assert any("INFO depth: Z, metres" in line for line in lines)
    assert any("DEBUG" in line and "so they are distances." in line for line in lines)
    assert "ERROR" in lines[-1] and "o.xyz" in lines[-1]
    assert all(f" {os.getpid()} " in line for line in lines)


def test_log_that_cannot_be_written_is_refused(capsys, plate, tmp_path, monkeypatch):
    monkeypatch.setenv(FILE_VARIABLE, str(tmp_path / "none" / "a.log"))
    assert main(["render", str(plate), "-o", str(tmp_path / "o.exr")]) == 2
    assert f"{FILE_VARIABLE}=" in capsys.readouterr().err


def test_copy_of_explained_sentence_keeps_its_details():
    sentence = pickle.loads(pickle.dumps(Explained("Short.", "Long.")))
    assert (sentence, sentence.why) == ("Short.", "Long.")
