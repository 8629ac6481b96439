"""What an export is asked for, and how a session starts and tells of it."""

import json
from dataclasses import replace

import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import Guides
from heatlens.core.model.view.view import DisplayOptions
from heatlens.deliver.export.options import options_in_panel
from heatlens.studio.settings.export_settings import (
    CAMERA_KINDS,
    ExportSettings,
    frame_kinds,
    proposed_settings,
)
from support.evening import FIRST, run_until, run_until_settled
from support.session_files import room_file

SETTINGS = ExportSettings(folder="/out", name="walls")


@pytest.mark.parametrize("kind", frame_kinds())
def test_export_output_numbers_frames_but_not_movies_or_single_frames(kind):
    suffix = frame_kinds()[kind]
    is_movie = suffix in (".mov", ".mp4")
    settings = replace(SETTINGS, kind=kind)
    assert settings.output == f"/out/walls{'' if is_movie else '.####'}{suffix}"
    single = replace(settings, is_single=True)
    assert single.output == f"/out/walls{suffix}"
    named = replace(single, frames="3-4")
    assert named.output == settings.output
    assert settings.is_linear is (suffix == ".exr")


@pytest.mark.parametrize("kind", CAMERA_KINDS)
def test_camera_output_has_the_name_of_the_frames(kind):
    assert replace(SETTINGS, camera_kind=kind).camera_output == f"/out/walls{CAMERA_KINDS[kind]}"


def test_export_quality_is_that_of_the_shot_unless_one_is_chosen():
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0))
    assert SETTINGS.shot_at_quality(shot) is shot and shot.defocus.quality is None
    for quality in Quality:
        other = replace(SETTINGS, quality=str(quality)).shot_at_quality(shot)
        assert other.defocus == replace(shot.defocus, quality=quality)


def test_export_job_has_look_and_guides_only_for_display_pictures():
    look = DisplayOptions(exposure_stops=1.5)
    guides = Guides(aspect=2.39, opacity=0.5, thirds=True)
    linear = json.loads(SETTINGS.job(look, guides, "walls"))
    shown = replace(SETTINGS, kind="PNG (as displayed)")
    assert "1.5" not in json.dumps(linear) and "2.39" not in json.dumps(linear)
    plain = shown.job(look, guides, "walls")
    drawn = replace(shown, with_guides=True).job(look, guides, "walls")
    assert "1.5" in plain and "2.39" not in plain and '"walls"' in plain
    assert "2.39" in drawn and "0.5" in drawn
    unmatted = replace(shown, with_guides=True).job(look, replace(guides, aspect=None), "")
    assert "0.5" not in unmatted.replace("1.5", "")
    assert set(options_in_panel(is_exr=True)) != set(options_in_panel(is_exr=False))


def test_proposed_settings_lie_beside_the_plate(tmp_path):
    settings = proposed_settings(tmp_path / "walls.1001.exr")
    assert settings.folder == str(tmp_path / "walls_dof") and settings.name == "walls"
    assert (settings.kind, settings.quality, settings.camera_kind) == (
        *("EXR (linear)", "", "USD"),
    )
    assert not (settings.with_guides or settings.is_single)


@pytest.fixture
def exports(session):
    return session.files.exports


def test_propose_sets_export_settings_once_for_each_source(session, exports, tmp_path):
    exports.propose()
    assert exports.settings.name == "walls" and not exports.settings.is_single
    exports.settings = replace(exports.settings, name="mine")
    exports.propose()
    assert exports.settings.name == "mine"
    session.time.timeline.set_out()
    exports.propose()
    assert exports.settings.is_single and exports.played.count == 1
    session.files.commands.open(str(room_file(tmp_path / "still.exr", 8, 6)))
    run_until(session, lambda: session.editing.shot.source.endswith("still.exr"), "the still")
    exports.propose()
    assert exports.settings.name == "still" and exports.settings.is_single
    assert exports.played is None


class RecordingExportRun:
    """Stand-in for `ExportRun` that records each request."""

    is_busy, state = False, None

    def __init__(self, wake=None):
        self.requests = []

    def export(self, *args):
        self.requests.append(("export", *args))

    def camera(self, *args):
        self.requests.append(("camera", *args))

    def sheet(self, *args):
        self.requests.append(("sheet", *args))

    def close(self):
        pass


def test_export_run_gets_the_shot_output_job_and_place(session, exports, tmp_path):
    exports.run = run = RecordingExportRun()
    exports.propose()
    exports.settings = replace(exports.settings, folder=str(tmp_path / "a" / "b"))
    exports.export()
    exports.write_camera()
    exports.write_sheet(tmp_path / "p.html", "Walls")
    (_, shot, output, job, place), (_, *camera), (_, *sheet) = run.requests
    assert shot == session.time.timeline.timed_shot and shot.frames.first == FIRST
    assert output == exports.settings.output and (tmp_path / "a" / "b").is_dir()
    assert json.loads(job) and place == exports.settings.place
    assert camera == [shot, exports.settings.camera_output]
    assert sheet[:2] == [shot, str(tmp_path / "p.html")] and sheet[2][:2] == ["--title", "Walls"]
    run.is_busy = True
    exports.write_sheet(tmp_path / "p.html", "Walls")
    assert len(run.requests) == 3 and "has finished" in session.messages.text
    assert exports.why_not == ""


def test_export_reports_folder_that_cannot_be_made(session, exports, tmp_path):
    exports.run = run = RecordingExportRun()
    (tmp_path / "file").write_text("")
    exports.settings = replace(exports.settings, folder=str(tmp_path / "file" / "out"))
    exports.export()
    assert run.requests == [] and "file" in session.messages.text
    run_until_settled(session)
