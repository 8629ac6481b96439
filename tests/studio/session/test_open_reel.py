"""A reel in a session: one shot is open, a step opens the next, and no edit is lost."""

from dataclasses import replace

import pytest

from heatlens.core.model.curves.frames import Ending, FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.reel import Reel, ReelShot, Retime
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.render.source import opener
from heatlens.studio.board.board import Board
from heatlens.studio.board.requests import Focus
from support.evening import (
    FIRST,
    LAST,
    begin_session,
    run_loop_once,
    run_until,
    run_until_settled,
    write_plates,
)

CUT = FrameRange(1005, 1010)


@pytest.fixture
def reel(tmp_path):
    """Write a reel: plates, missing media, and a shot file with its own focus."""
    source = write_plates(tmp_path)
    shot_path = tmp_path / "s3.heatlens.json"
    shot = Shot(Lens(50.0, 2.8, 3.0, 36.0), source=source, frames=FrameRange(FIRST, LAST))
    write_shot(shot_path, shot)
    missing = ReelShot("s2", "", None, ("its media are missing: /nowhere",))
    path = tmp_path / "cut.heatreel.json"
    shots = ReelShot("s1", source, CUT), missing, ReelShot("s3", str(shot_path), CUT)
    write_reel(path, Reel("cut", shots))
    return path


@pytest.fixture
def reel_session(tmp_path, reel):
    session = begin_session(tmp_path / "preferences", str(reel))
    run_until_settled(session)
    yield session
    session.close()


def wait_for_shot_file(session, name: str) -> None:
    """Wait until the shot file of this name is open."""

    def is_open() -> bool:
        path = session.files.documents.path
        return path is not None and path.name == name

    run_until(session, is_open, name)
    run_until_settled(session)


def test_reel_opens_first_shot_with_its_frames_of_the_cut(reel_session):
    open_reel = reel_session.files.reel
    assert open_reel.number == 0 and reel_session.editing.shot.in_out == CUT
    assert reel_session.editing.frame == CUT.first


def test_reel_steps_skip_missing_media_and_report_the_last_shot(reel_session):
    open_reel, board = reel_session.files.reel, Board(reel_session)
    board.do("Next shot")
    wait_for_shot_file(reel_session, "s3.heatlens.json")
    assert open_reel.number == 2
    board.do("Next shot")
    assert open_reel.number == 2 and "last shot" in reel_session.messages.text
    board.do("Previous shot")
    run_until_settled(reel_session)
    assert open_reel.number == 0 and reel_session.editing.shot.in_out == CUT
    open_reel.go(1)
    assert open_reel.number == 0 and "/nowhere" in reel_session.messages.text


def test_reel_step_saves_the_open_shot_file(reel_session, reel):
    open_reel, board = reel_session.files.reel, Board(reel_session)
    open_reel.go(2)
    wait_for_shot_file(reel_session, "s3.heatlens.json")
    board.do(Focus(5.0))
    run_until_settled(reel_session)
    open_reel.go(0)
    run_until_settled(reel_session)
    assert read_shot(reel.parent / "s3.heatlens.json").lens.focus_distance_m == 5.0
    assert open_reel.focus_of(2).first_m == 5.0


def test_focus_of_reads_focus_at_a_cut_before_the_shot_is_opened(reel_session):
    open_reel = reel_session.files.reel
    assert open_reel.focus_of(2).first_m == open_reel.focus_of(2).last_m == 3.0
    assert (
        open_reel.focus_of(0).last_m == reel_session.editing.shot.lens_at(CUT.last).focus_distance_m
    )


def test_next_shot_is_barred_without_a_reel(session):
    commands = {command.name: command for command in Board(session).commands}
    assert commands["Next shot"].why_not() and not commands["Next shot"].is_on


def test_reel_stays_when_another_file_is_opened(reel_session, tmp_path):
    """The list of shots stays, and its next shot is opened as before."""
    (tmp_path / "other").mkdir()
    other = write_plates(tmp_path / "other")
    reel_session.files.commands.open(other)
    run_until(reel_session, lambda: reel_session.editing.shot.source == other, "the other plates")
    reel_session.files.reel.go(2)
    wait_for_shot_file(reel_session, "s3.heatlens.json")
    assert reel_session.files.reel.number == 2


@pytest.fixture
def cut(tmp_path):
    """Open a reel of two plates, a shot that is missing and a shot file; all of two frames."""
    sources = []
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
        sources.append(write_plates(tmp_path / name))
    shot_path = tmp_path / "c.heatlens.json"
    frames = FrameRange(1003, 1004)
    lens = Lens(50.0, 2.8, 3.0, 36.0)
    write_shot(
        shot_path, Shot(lens, source=sources[2], frames=FrameRange(FIRST, LAST), in_out=frames)
    )
    shots = (
        ReelShot(name="a", source=sources[0], frames=FrameRange(1005, 1006)),
        ReelShot(name="gone", source="", frames=None, notes=("its media are missing: /nowhere",)),
        ReelShot(name="b", source=sources[1], frames=FrameRange(1010, 1011)),
        ReelShot("c", str(shot_path)),
    )
    path = tmp_path / "cut.heatreel.json"
    write_reel(path, Reel("cut", shots))
    session = begin_session(tmp_path / "preferences", str(path))
    run_until_settled(session)
    yield session
    session.close()


def collect_played_frames(session, count: int) -> list[tuple[str, int]]:
    """Play on until the playhead was on `count` frames; return them with their plates."""
    played_frames: list[tuple[str, int]] = []

    def has_all() -> bool:
        current = session.editing.shot.source.split("/")[-2], session.editing.frame
        if not played_frames or played_frames[-1] != current:
            played_frames.append(current)
        return len(played_frames) == count

    run_until(session, has_all, "the end")
    return played_frames


ALL_FRAMES = [("a", 1005), ("a", 1006), ("b", 1010), ("b", 1011), ("c", 1003), ("c", 1004)]


def test_reel_playback_crosses_cuts_and_starts_over(cut):
    timeline = cut.time.timeline
    timeline.playback.ending = Ending.REEL
    timeline.play(1)
    assert collect_played_frames(cut, 8) == [*ALL_FRAMES, *ALL_FRAMES[:2]]
    assert timeline.playback.direction == 1 and cut.files.reel.number == 0


def test_loop_playback_stays_within_the_shot_of_the_reel(cut):
    cut.time.timeline.play(1)
    assert collect_played_frames(cut, 4) == [*ALL_FRAMES[:2], *ALL_FRAMES[:2]]


def test_reel_playback_stops_when_next_shot_cannot_be_opened(cut, tmp_path):
    cut.files.reel.go(2)
    run_until_settled(cut)
    (tmp_path / "c.heatlens.json").write_text("{")
    timeline = cut.time.timeline
    timeline.playback.ending = Ending.REEL
    timeline.play(1)
    run_until(cut, lambda: timeline.playback.direction == 0, "the stop")
    assert "c.heatlens.json" in cut.messages.text
    assert cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr")


def test_reel_opens_the_next_shot_ahead(cut, tmp_path, monkeypatch):
    """Its first plate is read while the shot before is open, and not once more at the cut."""
    prepared = cut.source.opener._prepared
    run_until(
        cut, lambda: prepared._future is not None and prepared._future.done(), "the next plate"
    )
    monkeypatch.setattr(opener, "_open", lambda _: pytest.fail("opened once more"))
    cut.files.reel.step(1)
    run_loop_once(cut)
    assert cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr")
    assert cut.editing.frame == 1010


def test_in_out_of_the_cut_does_not_count_as_a_change(cut, tmp_path):
    """No copy for recovery is written, and no question to save appears during playback."""
    assert cut.editing.shot.in_out == FrameRange(1005, 1006)
    assert not cut.files.documents.window_title.endswith("*")
    assert not cut.editing.history.past
    run_until_settled(cut)
    assert not list(tmp_path.rglob("unsaved/*"))


def test_in_out_of_the_cut_applies_to_a_shot_file(reel_session):
    """The shot plays the frames that the reel shows of it, and is not marked as changed."""
    reel_session.files.reel.go(2)
    wait_for_shot_file(reel_session, "s3.heatlens.json")
    assert reel_session.editing.shot.in_out == CUT and reel_session.editing.frame == CUT.first
    assert reel_session.time.timeline.played == CUT
    assert reel_session.files.documents.is_saved and not reel_session.editing.history.past


def test_shot_file_opened_outside_the_reel_has_its_own_in_out(reel_session, reel):
    reel_session.files.reel.go(2)
    wait_for_shot_file(reel_session, "s3.heatlens.json")
    reel_session.files.commands.open(str(reel.parent / "s3.heatlens.json"))
    run_until(reel_session, lambda: reel_session.editing.shot.in_out is None, "the whole shot")


def test_reel_shot_without_a_file_keeps_its_edits_across_steps(cut, tmp_path):
    """It keeps its focus and its keys, and asks no question about recovery."""
    open_reel, board = cut.files.reel, Board(cut)
    board.do(Focus(3.0))
    cut.files.reel.step(1)
    run_until(cut, lambda: cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr"), "b")
    run_until_settled(cut)
    board.do("Set key")
    open_reel.step(-1)
    run_until(cut, lambda: cut.editing.shot.source == str(tmp_path / "a" / "walls.####.exr"), "a")
    run_until_settled(cut)
    assert cut.editing.shot.lens.focus_distance_m == 3.0
    assert cut.editing.shot.in_out == FrameRange(1005, 1006)
    open_reel.step(1)
    run_until(
        cut, lambda: cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr"), "b again"
    )
    run_until_settled(cut)
    assert cut.editing.shot.key_frames == (1010.0,)
    assert cut.files.documents.offer is None and not cut.files.documents.is_reading


def test_reel_playback_shows_a_retimed_shot_as_the_edit_does(cut, tmp_path):
    """The second shot plays at half speed: each of its frames is shown twice."""
    reel = cut.files.reel.reel
    slow = replace(reel.shots[0], retime=Retime(start=1005.0, speed=0.5, count=4))
    cut.files.reel.change(reel.with_shots((slow, *reel.shots[1:])))
    timeline, shown = cut.time.timeline, []
    timeline.playback.ending = Ending.REEL
    run_loop_once(cut)
    next_frame = timeline.playback.next_frame

    def note(frame, frames, rate, is_ready):
        due = timeline.playback.is_due(rate) and is_ready
        result = next_frame(frame, frames, rate, is_ready)
        shown.extend([result] * due)
        return result

    timeline.playback.next_frame = note
    timeline.play(1)
    assert collect_played_frames(cut, 3) == ALL_FRAMES[:3]
    assert shown[:3] == [1005, 1006, 1006]
