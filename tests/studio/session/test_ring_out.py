"""The window sends its lens as a camera does: when it changes, and now and then at rest."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.fronts.commands.main import main
from heatlens.media.live.ring.sources import SILENT_AFTER_S, LensSample
from heatlens.studio.session.live.ring_hand import RingOut
from heatlens.studio.session.shot.editing import Editing


class Line:
    """What would have been sent."""

    def __init__(self) -> None:
        self.samples: list[LensSample] = []
        self.is_cut = False

    def send(self, sample: LensSample) -> None:
        if self.is_cut:
            raise InputError("Nothing can be sent.")
        self.samples.append(sample)


def no_timecode(shot: Shot, frame: int) -> None:
    """Neither the shot nor its plate has a timecode."""


@pytest.fixture
def editing() -> Editing:
    return Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0)), lambda _: None)


def test_a_change_is_sent_at_once_and_a_lens_that_rests_before_it_counts_as_silent(editing):
    line, now = Line(), [100.0]
    out = RingOut(line, editing, print, no_timecode, clock=lambda: now[0])
    out.poll()
    out.poll()
    told = [(s.focus_distance_m, s.f_stop, s.focal_length_mm) for s in line.samples]
    assert told == [(2.0, 2.8, 50.0)]
    editing.edit_lens(replace(editing.lens, focus_distance_m=1.5))
    out.poll()
    assert line.samples[-1].focus_distance_m == 1.5
    editing.frame = 30  # 24 frames a second
    out.poll()
    assert line.samples[-1].timecode == Timecode(0, 0, 1, 6)
    wait_s = out.seconds_until_needed()
    assert wait_s is not None and 0 < wait_s < SILENT_AFTER_S
    now[0] += 2 * wait_s
    assert out.seconds_until_needed() > 0  # 0 would have the window work on without a frame
    out.poll()
    assert len(line.samples) == 4


def test_the_lens_has_the_timecode_and_the_rate_of_the_shot(editing):
    line, told = Line(), Timecode(10, 0, 0, 5)
    editing.edit(replace(editing.shot, frames_per_second=25.0))
    RingOut(line, editing, print, lambda shot, frame: (frame, told)).poll()
    (sample,) = line.samples
    assert (sample.timecode, sample.frames_per_second) == (told, 25.0)


def test_a_network_that_refuses_is_said_once(editing):
    line, said = Line(), []
    out = RingOut(line, editing, said.append, no_timecode)
    line.is_cut = True
    for _ in range(3):
        out.poll()
    assert len(said) == 1 and "not sent any more" in said[0]
    assert out.seconds_until_needed() is None


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--lens-out", "osc://:9000"), "as OpenTrackIO"),
        (("--lens-out", "opentrackio", "--lens-in", "opentrackio"), "cannot share an address"),
    ],
)
def test_what_cannot_be_sent_is_explained_before_a_window_opens(options, told, capsys):
    assert main(["view", "demo", "--new-window", *options]) == 2
    assert told in capsys.readouterr().err
