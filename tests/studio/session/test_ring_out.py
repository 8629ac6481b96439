"""The window sends its lens as a camera does: when it changes, and now and then at rest."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.fronts.commands.main import main
from heatlens.media.live.ring.sources import SILENT_AFTER_S, LensSample
from heatlens.studio.session.live.ring_follower import RingOut
from heatlens.studio.session.shot.editing import Editing


class Line:
    """Stand-in for a sender that keeps the samples, or refuses them while `is_cut`."""

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


def test_ring_out_sends_changes_at_once_and_repeats_before_silence(editing):
    line, clock_s = Line(), [100.0]
    out = RingOut(line, editing, print, no_timecode, clock=lambda: clock_s[0])
    out.poll()
    out.poll()
    sent_values = [(s.focus_distance_m, s.f_stop, s.focal_length_mm) for s in line.samples]
    assert sent_values == [(2.0, 2.8, 50.0)]
    editing.edit_lens(replace(editing.lens, focus_distance_m=1.5))
    out.poll()
    assert line.samples[-1].focus_distance_m == 1.5
    editing.frame = 30  # 24 frames a second
    out.poll()
    assert line.samples[-1].timecode == Timecode(hours=0, minutes=0, seconds=1, frames=6)
    wait_s = out.seconds_until_needed()
    assert wait_s is not None and 0 < wait_s < SILENT_AFTER_S
    clock_s[0] += 2 * wait_s
    assert out.seconds_until_needed() > 0  # 0 would have the window work on without a frame
    out.poll()
    assert len(line.samples) == 4


def test_sent_sample_has_timecode_and_rate_of_the_shot(editing):
    line, timecode = Line(), Timecode(hours=10, minutes=0, seconds=0, frames=5)
    editing.edit(replace(editing.shot, frames_per_second=25.0))
    RingOut(line, editing, print, lambda shot, frame: (frame, timecode)).poll()
    (sample,) = line.samples
    assert (sample.timecode, sample.frames_per_second) == (timecode, 25.0)


def test_failed_sending_of_the_lens_is_reported_once(editing):
    line, messages = Line(), []
    out = RingOut(sender=line, editing=editing, notify=messages.append, timecode_at=no_timecode)
    line.is_cut = True
    for _ in range(3):
        out.poll()
    assert len(messages) == 1 and "not sent any more" in messages[0]
    assert out.seconds_until_needed() is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--lens-out", "osc://:9000"), "as OpenTrackIO"),
        (("--lens-out", "opentrackio", "--lens-in", "opentrackio"), "cannot share an address"),
    ],
)
def test_wrong_lens_out_option_is_refused_before_a_window_opens(options, message, capsys):
    assert main(["view", "demo", "--new-window", *options]) == 2
    assert message in capsys.readouterr().err
