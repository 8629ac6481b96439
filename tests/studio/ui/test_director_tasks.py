"""What a director does most, played by mouse and keys: no task takes more acts than it may.

A click, a key with its modifiers, a drag, a typed value and a choice in a list are an act each.
Moving the pointer is none.
"""

import re
from pathlib import Path

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.view.view import Compare
from heatlens.media.documents.reel_file import read_reel
from heatlens.media.documents.shot_file import write_autosave, write_shot
from support.gui import Gui, gui_of
from support.mattes import matte_plate
from support.scene_window import picture_center, reset_scene
from support.sequences import FIRST
from support.session_files import BALL, POST, QUICK, SKY, room_file
from support.timeline_window import reset_window

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE


class Hand:
    """Plays on a window, and counts its acts."""

    def __init__(self, gui: Gui) -> None:
        self.gui, self.acts = gui, 0

    def click(self, name: str, share: float = 0.5) -> None:
        """Click on a control, at this share of its width."""
        self.gui.frame(3)
        x0, y0, x1, y1 = self.gui.rect(name)
        self.gui.click((x0 + share * (x1 - x0), (y0 + y1) / 2))
        self._done()

    def key(self, key: imgui.Key, **modifiers: bool) -> None:
        self.gui.key(key, **modifiers)
        self._done()

    def choose(self, name: str, item: str) -> None:
        """Choose in a drop-down list."""
        self.gui.frame(3)
        self.gui.click(self.gui.middle(name))
        self.gui.click(self.gui.middle(f"{name}: {item}"))
        self._done()

    def type(self, name: str, text: str) -> None:
        """Type a value into a slider, with Ctrl+click."""
        self.gui.frame(30)
        self.gui.hold(K.mod_ctrl)
        self.gui.click(self.gui.middle(name))
        self.gui.hold(K.mod_ctrl, down=False)
        self.gui.key(K.a, ctrl=True)
        self.gui.type(text)
        self.gui.key(K.enter)
        self._done()

    def mark(self, pixel: tuple[int, int]) -> None:
        """Set a mark with Ctrl+Shift+click on a pixel."""
        self.gui.frame(30)  # so that two clicks are no double click
        for mod in (K.mod_ctrl, K.mod_shift):
            self.gui.hold(mod)
        self.gui.click(self.gui.at_picture(pixel[0] + 0.5, pixel[1] + 0.5))
        for mod in (K.mod_ctrl, K.mod_shift):
            self.gui.hold(mod, down=False)
        self._done()

    def _done(self) -> None:
        self.acts += 1
        self.gui.rest()
        self.gui.frame(3)


@pytest.fixture
def gui(film) -> Gui:
    return reset_window(film)


@pytest.fixture
def hand(gui) -> Hand:
    return Hand(gui)


def test_distance_of_what_is_under_the_pointer_takes_no_act(gui):
    gui.settled()
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.frame(2)
    px = gui.screen.picture.hovered_px
    assert re.search(r"\d m\b", gui.screen.status.words(px))


def test_three_looks_take_six_acts_and_one_shows_them(gui, hand):
    for share in (0.2, 0.5, 0.8):
        hand.click("f-stop", share)
        hand.key(K.l, shift=True)
    stops = [look.lens.f_stop for look in gui.session.facts.shot.looks]
    assert stops == sorted(set(stops)) and len(stops) == 3 and hand.acts <= 6
    hand.key(K.w, shift=True)
    assert gui.session.facts.view.compare is Compare.GRID and hand.acts <= 7


def test_pull_over_three_things_takes_eight_acts(gui, hand):
    gui.session.time.marks.pulls.set_length(2)
    for pixel in (BALL, POST, SKY):
        hand.mark(pixel)
    hand.click("A on the bar")
    for shift in (True, False):
        hand.key(K.m, shift=True)
        hand.key(K.enter, shift=shift)
    keys = gui.session.facts.shot.curves.focus_distance_m.keys
    assert [key.frame for key in keys] == [FIRST, FIRST + 2, FIRST + 4]
    assert hand.acts <= 8


@pytest.fixture
def started(gui, monkeypatch) -> list[tuple[str, str]]:
    """Return a list to which each export adds its kind and its file, in place of a process."""
    run, started = gui.session.files.exports.run, []
    for kind in ("export", "camera", "sheet"):
        note = lambda _shot, output, *_, kind=kind, **__: started.append((kind, output))  # noqa: E731
        monkeypatch.setattr(run, kind, note)
    return started


def test_movie_with_burn_in_takes_four_acts(gui, hand, started):
    hand.key(K.e, ctrl=True)
    hand.choose("format", "H.264 movie")
    hand.click("burn in frame, timecode, lens")
    hand.click("Export")
    ((kind, output),) = started
    assert (kind, output[-4:]) == ("export", ".mp4") and hand.acts <= 4
    assert gui.session.files.exports.settings.burn_in


def test_camera_file_takes_two_acts(hand, started):
    hand.key(K.e, ctrl=True)
    hand.click("Write camera")
    assert started[0][0] == "camera" and hand.acts <= 2


def test_pull_sheet_takes_three_acts(gui, hand, started):
    gui.session.editing.begin(gui.session.facts.shot.with_key(FIRST, FOCUS, 1.5))
    hand.click("menu File")
    hand.click("item Pull sheet...")
    hand.key(K.enter)
    gui.until(lambda: started, "the sheet")
    assert started[0][0] == "sheet" and hand.acts <= 3


def test_unsaved_work_comes_back_with_one_act(gui, hand, tmp_path):
    path, saved = tmp_path / "a.heatlens.json", gui.session.facts.shot
    write_shot(path, saved)
    write_autosave(path, saved.with_key(FIRST, FOCUS, 1.5))
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.files.documents.offer is not None, "the question")
    gui.frame(3)
    hand.key(K.enter)
    gui.until(lambda: gui.session.files.documents.path == path, "the shot")
    assert gui.session.facts.shot.key_frames == (FIRST,) and hand.acts <= 1


def test_second_window_takes_one_act(gui, hand):
    hand.key(K.f12)
    assert gui.ui.has_feed and hand.acts <= 1
    gui.ui.has_feed = False


def test_focus_follows_a_thing_of_a_matte_in_three_acts(session_context, tmp_path):
    for frame in (1, 2, 3):
        matte_plate(tmp_path / f"things.{frame:04}.exr", 2.0 + 0.1 * frame)
    with gui_of(session_context, tmp_path / "things.####.exr", defocus=QUICK) as gui:
        hand = Hand(gui)
        hand.mark((16, 12))
        imgui.set_window_focus("Marks")
        hand.acts += 1  # the tab was clicked
        hand.click("follow hero")
        gui.until(lambda: gui.session.facts.shot.key_frames, "the keys")
        focus_m = [gui.session.facts.shot.lens_at(it).focus_distance_m for it in (1, 2, 3)]
        assert focus_m == pytest.approx([2.1, 2.2, 2.3], abs=0.05) and hand.acts <= 3


def test_reel_of_three_shots_takes_four_acts(session_context, tmp_path):
    rooms = [str(room_file(tmp_path / f"{name}.exr")) for name in ("one", "two", "three")]
    with gui_of(session_context, rooms[0], defocus=QUICK) as gui:
        hand, reel = Hand(gui), gui.session.files.reel
        gui.session.files.commands.open_dropped(rooms)
        hand.acts += 1
        gui.until(lambda: reel.reel is not None and reel.number == 0, "the reel")
        hand.key(K.right_arrow, ctrl=True)
        gui.until(lambda: gui.session.facts.shot.source == rooms[1], "the next shot")
        hand.click("save reel")
        gui.until(lambda: gui.ui.dialogs.is_open, "the dialog")
        hand.key(K.enter)
        gui.until(lambda: reel.path is not None and reel.path.exists(), "the file")
        saved = read_reel(reel.path)
        assert [Path(shot.source).stem for shot in saved.shots] == ["one", "two", "three"]
        assert hand.acts <= 4


def test_other_focal_length_keeps_the_size_of_a_mark_in_two_acts(window):
    gui = reset_scene(window)
    hand = Hand(gui)
    center = picture_center(gui)
    gui.hold(K.mod_ctrl), gui.hold(K.mod_shift)
    gui.click(center)
    gui.hold(K.mod_ctrl, down=False), gui.hold(K.mod_shift, down=False)
    gui.frame(3)
    before = gui.session.facts.shot
    (mark,) = before.marks
    hand.key(K.s)
    hand.type("focal length", str(2 * before.lens.focal_length_mm))
    after = gui.session.facts.shot
    assert after.lens.focal_length_mm == pytest.approx(2 * before.lens.focal_length_mm, rel=1e-3)
    assert hand.acts <= 2
    renderer, at = gui.session.pictures.renderer, (round(mark.x_px), round(mark.y_px))
    old_m, new_m = (
        renderer.scene_depth_m(shot, gui.session.facts.frame, *at) for shot in (before, after)
    )
    assert new_m == pytest.approx(2 * old_m, rel=0.05)
