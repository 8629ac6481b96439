"""The last net: what nobody foresaw is a sentence and a report, and the window goes on."""

import os
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

import heatlens
from heatlens.core.base import faults
from heatlens.core.base.background import Background
from heatlens.core.base.errors import FaultError, InputError
from heatlens.core.base.faults import (
    faults_reported,
    report_from_threads,
    told_error,
    write_report,
)
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands import info
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_shot
from heatlens.studio.session.exports.export_process import ExportRun
from heatlens.studio.ui import screen
from support.command_line import ENVIRONMENT
from support.gui import gui_of
from support.session_files import room_file


@pytest.fixture
def reports(tmp_path, monkeypatch) -> Path:
    """Return the folder that reports of this test go to."""
    folder = tmp_path / "reports"
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(folder))
    monkeypatch.delenv("HEATLENS_DEBUG", raising=False)
    return folder


def broken(*_: object) -> None:
    raise IndexError("list index\x1b[31m out of range")


def report_in(folder: Path) -> str:
    (path,) = folder.iterdir()
    return path.read_text(encoding="utf-8")


def test_a_fault_is_a_sentence_that_names_its_report(reports, expects_faults):
    with pytest.raises(FaultError) as told, faults_reported("It could not be read"):
        broken()
    (path,) = reports.iterdir()
    assert str(told.value).startswith("It could not be read; ") and "(Index" in str(told.value)
    assert str(told.value).endswith(f" {path}.")
    text = report_in(reports)
    assert (
        "in broken" in text and "Traceback" in text and f"heatlens {heatlens.__version__}" in text
    )
    assert "\x1b" not in text and "\\x1b[31m" in text


def test_what_the_user_can_mend_is_no_fault(reports):
    own = InputError("plate.exr is not there.")
    assert told_error(own) is own
    assert type(told_error(MemoryError())) is InputError
    full = told_error(OSError(28, "No space left on device", "/out/a.exr"))
    assert type(full) is InputError and str(full) == "/out/a.exr: No space left on device."
    assert not reports.exists()


def test_one_fault_is_written_once_and_old_reports_go(reports, expects_faults):
    for _ in range(3):
        with pytest.raises(FaultError), faults_reported():
            broken()
    assert len(list(reports.iterdir())) == 1
    for number in range(30):
        (reports / f"fault-20200101-0000{number:02}-x.log").write_text("old")
    write_report(ValueError("another"))
    assert len(list(reports.iterdir())) == faults._KEPT
    assert not (reports / "fault-20200101-000000-x.log").exists()


def test_without_a_place_for_reports_the_sentence_says_so(monkeypatch, tmp_path, expects_faults):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(tmp_path / "file" / "below"))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path / "file"))
    with pytest.raises(FaultError, match="No report could be written"), faults_reported():
        broken()


def test_a_command_ends_in_one_line_and_70(reports, monkeypatch, capsys, expects_faults):
    monkeypatch.setattr(info, "run", broken)
    assert main(["info", "plate.exr"]) == 70
    said = capsys.readouterr()
    assert said.out == "" and len(said.err.splitlines()) == 1
    assert said.err.startswith("heatlens: The command ended; this is a fault of heatlens")
    assert "in broken" in report_in(reports)


def test_on_request_the_traceback_is_shown(reports, monkeypatch, capsys, expects_faults):
    monkeypatch.setattr(info, "run", broken)
    monkeypatch.setenv("HEATLENS_DEBUG", "1")
    assert main(["info", "plate.exr"]) == 70
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_whatever_a_job_raises_is_told(reports, expects_faults):
    background: Background[int] = Background(lambda: None)
    background.start(broken)
    background.wait()
    with pytest.raises(FaultError, match="IndexError"):
        background.poll()
    assert background.poll() is None


def test_a_thread_that_fails_is_told_in_one_line(reports, monkeypatch, capfd, expects_faults):
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)
    report_from_threads()
    thread = threading.Thread(target=broken)
    thread.start()
    thread.join()
    said = capfd.readouterr()
    assert said.out == "" and len(said.err.splitlines()) == 1
    assert said.err.startswith("heatlens: A part of the program stopped; this is a fault")
    assert "in broken" in report_in(reports)


# The window


@pytest.fixture
def gui(session_context, tmp_path):
    with gui_of(session_context, room_file(tmp_path / "room.exr")) as gui:
        yield gui


def test_a_file_that_breaks_its_reader_leaves_the_window(
    reports, gui, tmp_path, monkeypatch, expects_faults
):
    monkeypatch.setattr("heatlens.render.source.scene_source.opened_scene", broken)
    (tmp_path / "bad.obj").write_text("")
    before = gui.session.source.plate
    gui.session.files.commands.open(str(tmp_path / "bad.obj"))
    gui.until(lambda: "fault of heatlens" in gui.session.messages.text, "the sentence")
    assert gui.session.source.plate is before and not gui.ui.is_over
    gui.frame(3)


def test_work_is_kept_before_a_fault_is_said(reports, gui, tmp_path, monkeypatch, expects_faults):
    session, path = gui.session, tmp_path / "s.heatlens.json"
    session.files.documents.save_as(path)
    gui.until(lambda: not session.files.documents._writing, "the file")
    session.editing.edit_lens(replace(session.facts.lens, f_stop=1.25))
    monkeypatch.setattr(session.time.scheduler, "_ask", broken)
    session.time.scheduler.update()
    assert "The picture could not be made; this is a fault" in session.messages.text
    assert read_shot(autosave_path(path)).lens.f_stop == 1.25
    assert read_shot(path).lens.f_stop != 1.25


@pytest.mark.parametrize("where", ["shot_question", "pull_popup"])
def test_a_fault_while_the_window_is_drawn_leaves_it_whole(
    reports, gui, monkeypatch, expects_faults, where
):
    """ImGui asserts that all that was begun is ended, also what the fault left open."""
    gui.settled()
    wanted = gui.screenshot()

    def half_drawn(*_: object) -> None:
        imgui.begin("never ended")
        imgui.push_style_var(imgui.StyleVar_.alpha, 0.5)
        imgui.begin_group()
        broken()

    monkeypatch.setattr(screen, where, half_drawn)
    gui.frame(3)
    assert "The window could not be drawn; this is a fault" in gui.session.messages.text
    monkeypatch.undo()
    gui.session.messages.clear()
    gui.frame(3)
    gui.settled()
    assert gui.session.messages.text == ""
    assert (gui.screenshot() != wanted).mean() < 0.02  # the times of the panel Speed change
    assert len(list(reports.iterdir())) == 1


# Code beside the user's files


def test_an_export_runs_no_code_of_the_current_folder(tmp_path, monkeypatch):
    """What was unpacked beside a shot may be called like a module of Python."""
    shot = tmp_path / "s.heatlens.json"
    monkeypatch.chdir(tmp_path)
    for name in ("json", "difflib", "argparse", "numpy"):
        (tmp_path / f"{name}.py").write_text("open('RAN', 'a').write(__name__)\nraise SystemExit\n")
    room_file(tmp_path / "room.exr")
    write_shot(shot, Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(tmp_path / "room.exr")))
    run = ExportRun(lambda: None)
    run.camera(read_shot(shot), str(tmp_path / "cam.json"), ("--frames", "1"))
    assert run._follower is not None
    run._follower.join()
    assert not (tmp_path / "RAN").exists()
    assert run.state is not None and run.state.code == 0, run.state.said


def test_the_process_itself_says_one_line(tmp_path, reports):
    """With everything in place, from the outside."""
    code = (
        "import sys\nfrom heatlens.fronts.commands import info, main\n"
        "def broken(args): raise KeyError('x')\ninfo.run = broken\n"
        "sys.exit(main.main(['info', 'plate.exr']))"
    )
    environment = ENVIRONMENT | {"HEATLENS_LOG_DIR": str(reports)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 70 and len(done.stderr.splitlines()) == 1
    assert os.fspath(reports) in done.stderr and "Traceback" in report_in(reports)
