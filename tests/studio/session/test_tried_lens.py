"""With auto key off, edits of keyed values are tried at the current frame and set no key."""

from dataclasses import replace

import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.shot.editing import Editing

FOCUS = LensParameter.FOCUS_DISTANCE
LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture
def editing(messages) -> Editing:
    shot = Shot(LENS).with_key(1, FOCUS, 2.0).with_key(11, FOCUS, 4.0)
    editing = Editing(shot, messages.append, is_sequence=lambda: True)
    editing.auto_key = False
    editing.frame = 5
    return editing


def test_tried_focus_is_shown_and_changes_no_key(editing, messages):
    before = editing.shot
    editing.edit_lens(replace(editing.lens, focus_distance_m=7.0))
    assert editing.lens.focus_distance_m == 7.0 and editing.trial_parameters == {FOCUS}
    assert editing.seen_shot.lens_at(5).focus_distance_m == 7.0
    assert editing.shot == before and "Set key keeps it" in messages[-1]


def test_tried_focus_is_dropped_at_another_frame(editing):
    keyed = editing.lens
    editing.edit_lens(replace(editing.lens, focus_distance_m=7.0))
    editing.frame = 6
    editing.frame = 5
    assert (
        editing.lens == keyed and not editing.trial_parameters and editing.seen_shot == editing.shot
    )


def test_edit_of_unkeyed_f_stop_is_kept_beside_a_tried_focus(editing):
    editing.edit_lens(replace(editing.lens, focus_distance_m=7.0))
    editing.edit_lens(replace(editing.lens, f_stop=4.0))
    assert editing.shot.lens.f_stop == 4.0
    assert (editing.lens.f_stop, editing.lens.focus_distance_m) == (4.0, 7.0)
    assert editing.shot.curves.focus_distance_m.key_at(5) is None
    editing.frame = 6
    assert editing.lens.f_stop == 4.0


def test_key_trial_values_sets_a_key_of_the_tried_focus(editing):
    editing.edit_lens(replace(editing.lens, focus_distance_m=7.0))
    editing.key_trial_values()
    assert editing.shot.lens_at(5).focus_distance_m == 7.0 and not editing.trial_parameters


def test_undo_drops_the_tried_focus(editing):
    editing.edit_lens(replace(editing.lens, focus_distance_m=7.0))
    editing.undo()
    assert not editing.trial_parameters


def test_first_edit_in_a_sequence_reports_which_frames_it_changes(messages):
    frames = [1]
    editing = Editing(Shot(LENS), messages.append, is_sequence=lambda: len(frames) > 1)
    editing.edit_lens(replace(LENS, focus_distance_m=4.0))
    assert messages == []
    frames.append(2)
    editing.edit_lens(replace(LENS, focus_distance_m=5.0))
    editing.edit_lens(replace(LENS, focus_distance_m=6.0))
    assert len(messages) == 1 and "same at all frames" in messages[0] and "Set key" in messages[0]
    assert messages[0].is_true()
    editing.edit(editing.shot.with_key(1, FOCUS, 2.0))
    assert not messages[0].is_true()  # so that the window shows it no longer
    editing.begin(Shot(LENS).with_key(1, FOCUS, 2.0))
    editing.frame = 3
    editing.edit_lens(replace(LENS, focus_distance_m=5.0))
    assert len(messages) == 2 and "frame 3" in messages[1]
