"""Earlier versions of a shot are kept, few and small, and another shot can be side B."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import Against, Compare
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.sequence.folder_walk import ChosenFile
from heatlens.studio.session.files import shot_versions
from heatlens.studio.session.files.shot_versions import VersionKind, keep_version, versions_in
from heatlens.studio.settings.file_purposes import PURPOSES
from support.evening import FIRST, RIGHT, run_until, run_until_settled

SHOT = Shot(Lens(50.0, 2.8, 4.0, 36.0))


def focused_at(distance_m: float) -> Shot:
    return replace(SHOT, lens=replace(SHOT.lens, focus_distance_m=distance_m))


@given(st.lists(st.tuples(st.floats(1.0, 900.0), st.sampled_from(VersionKind)), max_size=24))
def test_at_most_ten_versions_are_kept_and_close_autosaves_are_one(tmp_path_factory, writes):
    folder, now_s, expected = tmp_path_factory.mktemp("v") / "a", 1e9, []
    for pause_s, kind in writes:
        now_s += round(pause_s, 3)
        if expected and expected[-1][1] == "autosaved" and now_s - expected[-1][0] < 300.0 - 1e-3:
            expected.pop()
        keep_version(folder, focused_at(now_s), kind, now_s)
        expected.append((now_s, kind))
    kinds = [version.kind for version in versions_in(folder)]
    assert kinds == [kind for _, kind in reversed(expected)][:10]


def test_versions_of_all_shots_together_stay_small(tmp_path, monkeypatch):
    monkeypatch.setattr(shot_versions, "BYTES_MOST", 4000)
    (tmp_path / "versions" / "b").mkdir(parents=True)
    (tmp_path / "versions" / "b" / "notes.txt").write_text("of the user " * 1000)
    for index in range(12):
        folder = tmp_path / "versions" / "ab"[index % 2]
        keep_version(folder, focused_at(2.0 + index), VersionKind.SAVED, now_s=1e9 + index)
    files = list((tmp_path / "versions").glob("*/*.json"))
    assert sum(path.stat().st_size for path in files) <= 4000
    newest = versions_in(tmp_path / "versions" / "b")[0]
    assert (tmp_path / "versions" / "b" / "notes.txt").is_file()
    assert len(files) > 1 and newest.written_ms == int((1e9 + 11) * 1e3)


def test_shot_that_is_saved_twice_is_one_version(tmp_path):
    for now_s in (1e9, 1e9 + 1000.0):
        keep_version(tmp_path / "a", SHOT, VersionKind.SAVED, now_s=now_s)
    (version,) = versions_in(tmp_path / "a")
    assert version.written_ms == int((1e9 + 1000.0) * 1e3)


def test_saves_and_autosaves_of_a_shot_are_listed_with_time_and_counts(session, tmp_path):
    session.time.marks.set_point(RIGHT)
    session.editing.settle()
    run_until_settled(session)
    (autosaved,) = session.files.documents.versions.of_open()
    assert (autosaved.kind, autosaved.mark_count, autosaved.key_count) == ("autosaved", 1, 0)
    assert autosaved.words.endswith(", autosaved: 1 mark, 0 keys")
    session.files.documents.save_as(tmp_path / "walls.heatlens.json")
    run_until_settled(session)
    (saved,) = session.files.documents.versions.of_open()  # of the file, which is new
    assert saved.kind == "saved" and read_shot(saved.path).lens == session.editing.shot.lens


def test_other_shot_is_side_b_with_its_keys_on_the_open_frames(session, tmp_path):
    here = session.editing.shot
    other = here.with_key(FIRST, LensParameter.FOCUS_DISTANCE, 7.0)
    write_shot(tmp_path / "yesterday.heatlens.json", replace(other, source="/nowhere.exr"))
    choice = ChosenFile(PURPOSES["compare shot"], tmp_path / "yesterday.heatlens.json")
    session.files.commands.apply_choice(choice)
    view, sides = session.pictures.view, session.pictures.sides
    run_until(session, lambda: view.state.against is Against.SHOT, "the shot")
    assert view.state.compare is Compare.WIPE and "yesterday" in session.messages.text
    run_until(session, lambda: sides.picture_of_b(view.state) is not None, "side B")
    run_until_settled(session)
    picture = sides.picture_of_b(view.state)
    assert picture.shot.lens_at(FIRST).focus_distance_m == 7.0
    assert picture.shot.source == here.source and picture.is_whole
    assert session.pictures.live.output.shot.lens_at(FIRST).focus_distance_m == 4.0
    assert session.editing.shot == here
