"""Test the names of undo steps, which say what differs between two shots."""

from dataclasses import fields, replace

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.history import History, change_words
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot

SHOT = Shot(Lens(50.0, 2.0, 3.0, 36.0))


def test_change_words_name_what_differs_between_shots():
    lens = SHOT.lens
    for after, words in (
        (replace(SHOT, lens=replace(lens, focus_distance_m=4.0)), "focus"),
        (replace(SHOT, lens=replace(lens, f_stop=4.0)), "f-stop"),
        (SHOT.with_key(1, LensParameter.FOCUS_DISTANCE), "keys of the focus"),
        (replace(SHOT, marks=(DistanceMark("a", 2.0),)), "marks"),
        (replace(SHOT, in_out=FrameRange(1, 2)), "in and out points"),
        (replace(SHOT, defocus=DefocusSettings(quality=Quality.DRAFT)), "quality"),
        (replace(SHOT, lens=replace(lens, f_stop=4.0, focus_distance_m=9.0)), "f-stop and focus"),
        (SHOT, ""),
    ):
        assert set(change_words(SHOT, after).split(" and ")) == set(words.split(" and "))


def test_change_words_are_not_empty_for_frames_and_rate():
    others = {"in_out": FrameRange(1, 2), "frames": FrameRange(1, 2), "frames_per_second": 30.0}
    for field in fields(Shot):
        if field.name in others:
            assert change_words(SHOT, replace(SHOT, **{field.name: others[field.name]}))


def test_undo_and_redo_words_name_their_step():
    history = History.of(SHOT)
    assert (history.undo_words, history.redo_words) == ("", "")
    history = history.with_current(replace(SHOT, lens=replace(SHOT.lens, f_stop=8.0)))
    assert history.undo_words == "f-stop"  # a gesture under way counts
    history = history.undo()
    assert (history.undo_words, history.redo_words) == ("", "f-stop")
