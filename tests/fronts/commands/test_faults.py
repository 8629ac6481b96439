"""Test unforeseen exceptions: each becomes a message and a report, and the window continues."""

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
    report_faults,
    report_from_threads,
    to_heatlens_error,
    write_report,
)
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.farm.export_process import ExportRun
from heatlens.fronts.commands import info
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_shot
from heatlens.studio.ui import screen
from support.command_line import ENVIRONMENT
from support.gui import gui_of
from support.session_files import room_file


@pytest.fixture
def reports(tmp_path, monkeypatch) -> Path:
    """Return the folder for the reports of this test."""
    folder = tmp_path / "reports"
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(folder))
    monkeypatch.delenv("HEATLENS_DEBUG", raising=False)
    return folder


def raise_index_error(*_: object) -> None:
    raise IndexError("list index\x1b[31m out of range")


def report_in(folder: Path) -> str:
    (path,) = folder.iterdir()
    return path.read_text(encoding="utf-8")


def test_report_faults_raises_fault_error_that_names_report(reports, expects_faults):
    with pytest.raises(FaultError) as error, report_faults("It could not be read"):
        raise_index_error()
    (path,) = reports.iterdir()
    assert str(error.value).startswith("It could not be read; ") and "(Index" in str(error.value)
    assert str(error.value).endswith(f" {path}.")
    text = report_in(reports)
    assert (
        "in raise_index_error" in text
        and "Traceback" in text
        and f"heatlens {heatlens.__version__}" in text
    )
    assert "\x1b" not in text and "\\x1b[31m" in text


def test_input_memory_and_disk_errors_are_reported_without_fault(reports):
    input_error = InputError("plate.exr is not there.")
    assert to_heatlens_error(input_error) is input_error
    assert type(to_heatlens_error(MemoryError())) is InputError
    disk_error = to_heatlens_error(OSError(28, "No space left on device", "/out/a.exr"))
    assert (
        type(disk_error) is InputError and str(disk_error) == "/out/a.exr: No space left on device."
    )
    assert not reports.exists()


def test_same_fault_is_written_once_and_old_reports_are_deleted(reports, expects_faults):
    for _ in range(3):
        with pytest.raises(FaultError), report_faults():
            raise_index_error()
    assert len(list(reports.iterdir())) == 1
    for number in range(30):
        (reports / f"fault-20200101-0000{number:02}-x.log").write_text("old")
    write_report(ValueError("another"))
    assert len(list(reports.iterdir())) == faults._REPORTS_MOST
    assert not (reports / "fault-20200101-000000-x.log").exists()


def test_fault_message_says_if_no_report_can_be_written(monkeypatch, tmp_path, expects_faults):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(tmp_path / "file" / "below"))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path / "file"))
    with pytest.raises(FaultError, match="No report could be written"), report_faults():
        raise_index_error()


def test_fault_in_command_prints_one_line_and_exits_with_70(
    reports, monkeypatch, capsys, expects_faults
):
    monkeypatch.setattr(info, "run", raise_index_error)
    assert main(["info", "plate.exr"]) == 70
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    assert captured.err.startswith("heatlens: The command ended; this is a fault of heatlens")
    assert "in raise_index_error" in report_in(reports)


def test_debug_environment_prints_traceback(reports, monkeypatch, capsys, expects_faults):
    monkeypatch.setattr(info, "run", raise_index_error)
    monkeypatch.setenv("HEATLENS_DEBUG", "1")
    assert main(["info", "plate.exr"]) == 70
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_background_job_reports_any_exception_once(reports, expects_faults):
    background: Background[int] = Background(lambda: None)
    background.start(raise_index_error)
    background.wait()
    with pytest.raises(FaultError, match="IndexError"):
        background.poll()
    assert background.poll() is None


def test_failing_thread_prints_one_line_and_writes_report(
    reports, monkeypatch, capfd, expects_faults
):
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)
    report_from_threads()
    thread = threading.Thread(target=raise_index_error)
    thread.start()
    thread.join()
    captured = capfd.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    assert captured.err.startswith("heatlens: A part of the program stopped; this is a fault")
    assert "in raise_index_error" in report_in(reports)


# The window


@pytest.fixture
def gui(session_context, tmp_path):
    with gui_of(session_context, room_file(tmp_path / "room.exr")) as gui:
        yield gui


def test_window_survives_fault_in_file_reader(reports, gui, tmp_path, monkeypatch, expects_faults):
    monkeypatch.setattr("heatlens.render.source.scene_source.open_scene_source", raise_index_error)
    (tmp_path / "bad.obj").write_text("")
    plate_before = gui.session.source.plate
    gui.session.files.commands.open(str(tmp_path / "bad.obj"))
    gui.until(lambda: "fault of heatlens" in gui.session.messages.text, "the sentence")
    assert gui.session.source.plate is plate_before and not gui.ui.is_over
    gui.frame(3)


def test_fault_autosaves_shot_before_message(reports, gui, tmp_path, monkeypatch, expects_faults):
    session, path = gui.session, tmp_path / "s.heatlens.json"
    session.files.documents.save_as(path)
    gui.until(lambda: not session.files.documents._writes, "the file")
    session.editing.edit_lens(replace(session.facts.lens, f_stop=1.25))
    monkeypatch.setattr(session.time.scheduler, "_request_pictures", raise_index_error)
    session.time.scheduler.update()
    assert "The picture could not be made; this is a fault" in session.messages.text
    assert read_shot(autosave_path(path)).lens.f_stop == 1.25
    assert read_shot(path).lens.f_stop != 1.25


@pytest.mark.parametrize("function_name", ["draw_questions", "pull_popup"])
def test_window_recovers_from_fault_while_drawing_and_reports_it_once(
    reports, gui, monkeypatch, expects_faults, function_name
):
    """ImGui asserts that every begun window, style and group is ended, also after a fault."""
    gui.settled()
    screenshot_before = gui.screenshot()

    def half_drawn(*_: object) -> None:
        imgui.begin("never ended")
        imgui.push_style_var(imgui.StyleVar_.alpha, 0.5)
        imgui.begin_group()
        raise_index_error()

    monkeypatch.setattr(screen, function_name, half_drawn)
    gui.frame(3)
    assert "The window could not be drawn; this is a fault" in gui.session.messages.text
    monkeypatch.undo()
    gui.session.messages.clear()
    gui.frame(3)
    gui.settled()
    assert gui.session.messages.text == ""
    # The times in the panel Speed change.
    assert (gui.screenshot() != screenshot_before).mean() < 0.02
    assert len(list(reports.iterdir())) == 1


# Code beside the user's files


def test_export_runs_no_python_files_of_current_folder(tmp_path, monkeypatch):
    """Files beside a shot may have the names of Python modules, but must not be imported."""
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
    assert run.state is not None and run.state.code == 0, run.state.last_sentence


def test_fault_in_real_process_prints_one_line_and_exits_with_70(tmp_path, reports):
    """Run the whole program in a process of its own."""
    code = (
        "import sys\nfrom heatlens.fronts.commands import info, main\n"
        "def broken(args): raise KeyError('x')\ninfo.run = broken\n"
        "sys.exit(main.main(['info', 'plate.exr']))"
    )
    environment = ENVIRONMENT | {"HEATLENS_LOG_DIR": str(reports)}
    process = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    assert process.returncode == 70 and len(process.stderr.splitlines()) == 1
    assert os.fspath(reports) in process.stderr and "Traceback" in report_in(reports)
