"""Notices about what is missing in a source, and their answers."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.reel import EditOptions, Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.estimate import trusted
from heatlens.media.sequence.folder_walk import ChosenFile
from heatlens.studio.session.files import reel_reading
from heatlens.studio.settings.file_purposes import PURPOSES
from support.evening import FIRST, begin_session, run_until, run_until_settled, write_plates
from support.exr_files import write_file
from support.networks import write_network


@pytest.fixture
def session(tmp_path):
    session = begin_session(tmp_path / "preferences")
    yield session
    session.close()


def give(session, words: str) -> None:
    """Give the answer of these words to the notice that is shown."""
    notice = session.files.notices.first
    session.files.notices.answer(notice, next(it for it in notice.answers if it.words == words))


def test_file_that_cannot_be_opened_is_told_over_the_picture_that_stays(session, tmp_path):
    broken, pattern = tmp_path / "broken.exr", write_plates(tmp_path)
    broken.write_bytes(b"no exr")
    session.files.commands.open(pattern)
    run_until_settled(session)
    for words in ("Open another...", "OK"):
        session.files.commands.open(str(broken))
        run_until(session, lambda: session.files.notices.first is not None, "the notice")
        notice = session.files.notices.first
        assert "broken.exr is not" in notice.words and notice.answers[0].dialog == "open"
        give(session, words)
        assert session.files.notices.first is None and session.editing.shot.source == pattern


def test_missing_frames_are_named_and_shown_as_answered(session, tmp_path):
    pattern = write_plates(tmp_path)
    for frame in (FIRST + 3, *range(FIRST + 6, FIRST + 12)):
        (tmp_path / f"walls.{frame}.exr").unlink()
    session.files.commands.open(pattern)
    run_until_settled(session)
    assert session.files.notices.first.words == (
        "7 of 24 frames have no file: 1004, 1007, 1008, 1009 and 3 more."
    )
    give(session, "Show black")
    assert session.time.timeline.missing == "black" and session.files.notices.first is None


def test_missing_shots_of_a_cut_are_looked_for_in_another_folder(session, tmp_path, monkeypatch):
    missing = ReelShot("s2", "", None, ("its media are missing: /nowhere",))
    shots = ReelShot("s1", write_plates(tmp_path), FrameRange(FIRST, FIRST + 3)), missing
    path = tmp_path / "cut.heatreel.json"
    write_reel(path, Reel("cut", shots))
    session.files.commands.open(str(path))
    run_until_settled(session)
    notice = session.files.notices.first
    assert notice.words == "1 of 2 shots has no media here: s2."
    assert notice.answers[0].dialog == "media"
    folders = []

    def read_reel(path, options: EditOptions) -> Reel:
        folders.extend(options.folders)
        return Reel("cut", shots[:1])

    monkeypatch.setattr(reel_reading, "read_reel", read_reel)
    chosen_file = ChosenFile(PURPOSES["media"], tmp_path / "media" / "s2.0001.exr")
    session.files.commands.apply_choice(chosen_file)
    run_until(session, lambda: len(session.files.reel.reel.shots) == 1, "the reel once more")
    assert folders == [tmp_path / "media"] and session.files.notices.first is None


def test_guessed_depth_is_no_longer_asked_about_once_it_is_said_to_be_right(session, tmp_path):
    values = np.random.default_rng(7).uniform(0.02, 0.2, (32, 64)).astype(np.float32)
    values[0, 0] = 4.0  # most are near zero, as those of 1/z are
    grey = np.full((32, 64), 0.18, np.float16)
    write_file(tmp_path / "plane.exr", {"R": grey, "G": grey, "B": grey, "Z": values})
    session.files.commands.open(str(tmp_path / "plane.exr"))
    run_until_settled(session)
    guessed = session.source.plate
    assert guessed.depth.question
    give(session, f"{guessed.depth.convention.capitalize()} is right")
    run_until(session, lambda: session.source.plate is not guessed, "the plate once more")
    run_until_settled(session)
    plate = session.source.plate
    assert not plate.depth.question and plate.depth.convention is guessed.depth.convention
    np.testing.assert_array_equal(plate.depth_m, guessed.depth_m)
    assert session.files.notices.first is None


def test_depth_with_guessed_ends_is_changed_in_its_panel(session, tmp_path):
    picture = tmp_path / "photo.png"
    gray = np.tile(np.linspace(0, 255, 64, dtype=np.uint8), (32, 1))
    Image.fromarray(gray).convert("RGB").save(picture)
    session.files.commands.open(str(picture), PlateOptions(depth_side="right"))
    run_until_settled(session)
    answers = session.files.notices.first.answers
    assert [it.words for it in answers] == ["Change it...", "Leave it open"]
    assert answers[0].panel == "Source"


def test_scheduler_is_asked_about_again_after_its_place_was_changed(session, monkeypatch):
    monkeypatch.setattr(type(session.pictures.cluster), "awaits_consent", True)
    notices = session.files.notices
    first = ExportPlace(Where.CLUSTER, scheduler="tcp://127.0.0.1:8786", ahead=True)
    for place in (first, replace(first, scheduler="tcp://127.0.0.1:8787")):
        session.preferences.change(export_place=place)
        assert place.scheduler in notices.first.words
        give(session, "Not now")
        assert notices.first is None
    session.preferences.change(export_place=first)
    assert notices.first is None
    session.preferences.change(export_place=replace(first, ahead=False))
    assert first.scheduler in notices.first.words


def test_unknown_network_of_a_shot_runs_only_after_consent(session, tmp_path, monkeypatch):
    monkeypatch.setenv("HEATLENS_CONFIG_DIR", str(tmp_path / "config"))
    monkeypatch.setenv("HEATLENS_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv(trusted._RUN_ALL_VARIABLE, "0")
    monkeypatch.setattr(trusted, "_question_callbacks", [])
    picture, network = tmp_path / "p.png", write_network(tmp_path / "n.onnx")
    Image.fromarray(np.full((24, 32, 3), 90, np.uint8)).save(picture)
    options = PlateOptions(depth_model=str(network), near_m=1.0, far_m=9.0)
    path = tmp_path / "s.heatlens.json"
    write_shot(path, Shot(Lens(50.0, 2.0, 3.0, 36.0), source=str(picture), plate_options=options))
    session.files.commands.open(str(path))
    question = session.files.commands.unknown_network
    run_until(session, lambda: question.name, "the question")
    assert question.network == str(network) and session.source.plate is None
    question.run_network()
    run_until_settled(session)
    assert session.files.documents.path == path and session.facts.lens.focus_distance_m == 3.0
