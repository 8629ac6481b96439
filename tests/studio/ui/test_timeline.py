"""The timeline by mouse and keys: scrubbing, playing by a fake clock, gaps and damaged frames."""

import pytest
from imgui_bundle import imgui

from heatlens.core.model.curves.frames import FrameRange
from heatlens.render.rendered_frames.screen_work import CachedFrame
from support.gui import Gui
from support.sequences import FIRST, LAST, frame_file, sequence_files
from support.session_files import room_file
from support.timeline_window import Clock, current_frame, reset_window, ruler_position, type_into

K = imgui.Key


@pytest.fixture
def gui(ctx, film) -> Gui:
    return reset_window(film)


@pytest.fixture
def clock(gui) -> Clock:
    return gui.session.time.timeline.playback._clock


def wait_for_shown_frame(gui) -> int:
    """Wait for the picture of the playhead; return the frame whose plate is on the screen."""
    session = gui.session
    gui.until(lambda: session.facts.shown_picture.frame == current_frame(gui), "the picture")
    if isinstance(
        session.facts.shown_picture, CachedFrame
    ):  # rendered before, from the plate of its job
        return int(
            session.time.frames_ahead.jobs.job_of(current_frame(gui)).plate.path.name.split(".")[1]
        )
    return int(session.source.plate.path.name.split(".")[1])


def test_shot_starts_with_frames_and_rate_of_its_plate(gui):
    assert gui.session.facts.shot.frames == FrameRange(FIRST, LAST)
    assert gui.session.facts.shot.frames_per_second == 25.0


def test_drag_over_the_timeline_ruler_scrubs_within_the_frames(gui):
    gui.press(ruler_position(gui, 1003))
    frames = [wait_for_shown_frame(gui)]
    for number in (1004, 1006, 1002, 990, 1020):
        gui.move(ruler_position(gui, number))
        frames.append(wait_for_shown_frame(gui))
    gui.release()
    assert frames == [1003, 1004, 1006, 1002, FIRST, LAST]
    assert gui.session.editing.history.past == ()


def test_scale_of_the_focus_bar_stays_over_all_frames(gui):
    """The scene comes nearer from frame to frame; frames that are read but not shown count too."""
    gui.open(gui.session.source.opened.text)
    gui.until(lambda: len(gui.session.time.timeline.runs()) == 1, "all frames")
    gui.frame(2)
    bar_positions = []
    for number in (FIRST, 1004, LAST, FIRST):
        gui.session.time.timeline.go_to(number)
        wait_for_shown_frame(gui)
        gui.frame(2)
        bar_positions.append(gui.session.facts.histogram.scale_position(2.0))
    assert 0 < bar_positions[0] < 1 and bar_positions == pytest.approx(
        [bar_positions[0]] * len(bar_positions)
    )


@pytest.mark.parametrize(
    ("key", "start", "end"),
    [
        (K.right_arrow, 1003, 1004),
        (K.left_arrow, 1003, 1002),
        (K.left_arrow, FIRST, FIRST),
        (K.right_arrow, LAST, LAST),
        (K.home, 1004, FIRST),
        (K.end, 1004, LAST),
    ],
)
def test_arrow_home_and_end_keys_move_the_playhead(gui, key, start, end):
    gui.session.time.timeline.go_to(start)
    gui.key(key)
    assert current_frame(gui) == end and wait_for_shown_frame(gui) == end


def test_space_key_plays_by_the_clock_and_stops(gui, clock):
    gui.key(K.space)
    gui.frame(5)
    assert current_frame(gui) == FIRST  # no time has passed
    frames = []
    for _ in range(9):
        clock.now_s += 1 / 25
        assert gui.session.time.player.is_due
        gui.frame()
        frames.append(wait_for_shown_frame(gui))
    assert frames == [1002, 1003, 1004, 1005, 1006, 1007, 1008, 1001, 1002]
    gui.key(K.space)
    clock.now_s += 1.0
    gui.frame(3)
    assert current_frame(gui) == 1002 and not gui.session.time.player.is_due


def test_shift_space_plays_backwards_until_scrubbing(gui, clock):
    gui.key(K.space, shift=True)
    clock.now_s += 1 / 25
    gui.frame()
    assert current_frame(gui) == LAST
    gui.click(ruler_position(gui, 1003))
    clock.now_s += 1.0
    gui.frame(3)
    assert current_frame(gui) == 1003


def test_i_and_o_keys_set_the_played_frames(gui, clock):
    gui.session.time.timeline.go_to(1003)
    gui.key(K.i)
    gui.rest()
    gui.session.time.timeline.go_to(1005)
    gui.key(K.o)
    gui.rest()
    assert gui.session.facts.shot.in_out == FrameRange(1003, 1005)
    gui.key(K.home)
    assert current_frame(gui) == 1003
    gui.key(K.space)
    frames = []
    for _ in range(4):
        clock.now_s += 1 / 25
        gui.frame()
        frames.append(current_frame(gui))
    assert frames == [1004, 1005, 1003, 1004]
    gui.key(K.i, shift=True)
    assert gui.session.facts.shot.in_out is None
    gui.key(K.z, ctrl=True)
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot.in_out == FrameRange(1003, LAST)


def test_frame_and_rate_fields_take_typed_values(gui):
    type_into(gui, "frame", "1006")
    assert current_frame(gui) == 1006
    type_into(gui, "frame", "99999")
    assert current_frame(gui) == LAST
    gui.click(gui.middle("more transport"))
    gui.frame(2)
    type_into(gui, "frames per second", "24000/1001")
    assert gui.session.facts.shot.frames_per_second == 24000 / 1001
    type_into(gui, "frames per second", "fast")
    assert "is not a frame rate" in gui.session.messages.text
    assert gui.session.facts.shot.frames_per_second == 24000 / 1001
    gui.key(K.escape)


def test_typed_timecode_applies_to_the_current_frame(gui):
    gui.session.time.timeline.go_to(1003)
    gui.click(gui.middle("more transport"))
    gui.frame(2)
    type_into(gui, "timecode", "10:00:00:02")
    assert gui.session.facts.shot.start_timecode == "10:00:00:00"
    gui.session.time.timeline.go_to(LAST)
    gui.frame(2)
    gui.click(gui.middle("timecode"))
    gui.key(K.a, ctrl=True)
    gui.key(K.c, ctrl=True)
    assert imgui.get_clipboard_text() == "10:00:00:07"
    gui.key(K.escape)
    gui.key(K.escape)


def test_transport_buttons_move_and_play(gui, clock):
    for name, expected in (("last", LAST), ("back", LAST - 1), ("first", FIRST), ("on", FIRST + 1)):
        if name in ("last", "first"):  # rare ones, which the ruler and keys do too
            gui.click(gui.middle("more transport"))
            gui.frame(2)
        gui.click(gui.middle(f"transport {name}"))
        assert current_frame(gui) == expected
        gui.key(K.escape)
        gui.frame(2)
    gui.click(gui.middle("transport forwards"))
    clock.now_s += 1 / 25
    gui.frame()
    assert current_frame(gui) == FIRST + 2
    gui.click(gui.middle("transport forwards"))
    assert gui.session.time.timeline.playback.direction == 0


def test_timeline_wheel_zooms_and_middle_drag_pans(gui):
    gui.wheel(ruler_position(gui, 1003), 2)
    scale = gui.ui.timeline.scale
    assert scale.last - scale.first == pytest.approx(8 / 1.25**2)
    gui.drag(ruler_position(gui, 1006), ruler_position(gui, 1004), button=2)
    assert gui.ui.timeline.scale.first > scale.first
    gui.wheel(ruler_position(gui, 1003), -9)
    assert gui.ui.timeline.scale is None


def test_still_has_no_timeline(gui, tmp_path):
    gui.open(room_file(tmp_path / "still.exr"))
    assert not gui.ui.is_timeline_shown
    for key in (K.space, K.right_arrow, K.home, K.end, K.up_arrow, K.down_arrow):
        gui.key(key)
    assert gui.session.time.timeline.playback.direction == 0


# Gaps, damage, and frames that come


@pytest.fixture
def gappy(gui, tmp_path):
    """Return frames 1001 to 1005; 1003 is missing, 1004 damaged."""
    pattern = sequence_files(tmp_path, 1001, 1005)
    (tmp_path / "shot.1003.exr").unlink()
    damaged = tmp_path / "shot.1004.exr"
    damaged.write_bytes(damaged.read_bytes()[:700])
    gui.open(pattern)
    return gui


def states(gui) -> dict[int, str]:
    return {
        number: run.state
        for run in gui.session.time.timeline.runs()
        for number in range(run.first, run.last + 1)
    }


def test_timeline_runs_report_missing_and_damaged_frames(gappy):
    expected = {1001: "ready", 1002: "ready", 1003: "missing", 1004: "damaged", 1005: "ready"}
    gappy.until(lambda: states(gappy) == expected, "the states")


def test_playback_holds_over_gaps_and_reports_damaged_frames(gappy, clock):
    gappy.key(K.space)
    shown = []
    for _ in range(5):
        clock.now_s += 1 / 24
        gappy.frame()
        wait_for_shown_frame(gappy)
        shown.append(
            (
                current_frame(gappy),
                gappy.session.source.plate.path.name,
                gappy.session.messages.text,
            )
        )
    names = ["shot.1002.exr", "shot.1002.exr", "shot.1002.exr", "shot.1005.exr", "shot.1001.exr"]
    assert [s[:2] for s in shown] == list(zip([1002, 1003, 1004, 1005, 1001], names, strict=True))
    assert "shot.1004.exr" in shown[2][2] and shown[1][2] == ""


def test_missing_frame_can_be_shown_black(gappy):
    x0, y0, x1, y1 = (int(side) for side in gappy.rect("picture"))

    def contrast() -> float:
        return gappy.screenshot()[y0 + 60 : y1 - 4, x0 + 4 : x1 - 4].std()

    gappy.click(gappy.middle("notice Show black"))
    assert gappy.session.time.timeline.missing == "black"
    gappy.session.time.timeline.go_to(1003)
    gappy.frame(2)
    assert contrast() == 0
    gappy.session.time.timeline.go_to(1002)
    gappy.frame(2)
    assert contrast() > 0


def test_refresh_finds_new_frames(gappy, tmp_path):
    frame_file(tmp_path, 1003)
    frame_file(tmp_path, 1006)
    gappy.session.time.timeline.cache.refresh()
    gappy.until(lambda: gappy.session.time.timeline.frames.last == 1006, "the new frame")
    gappy.frame()  # the cached picture of 1002 does not stand for 1003 any more
    gappy.session.time.timeline.go_to(1003)
    assert wait_for_shown_frame(gappy) == 1003
