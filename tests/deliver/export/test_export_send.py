"""Test `heatlens export --send`: receivers get the lens of each finished frame."""

import time

import pytest

from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.live.ring.address import parse_ring_address
from heatlens.media.live.ring.receiver import LensReceiver
from heatlens.media.live.ring.sender import LensSender
from heatlens.media.live.ring.sources import RingSources
from support.exports import FRAMES, shot_of, write_plates
from support.patience import PATIENCE_S


@pytest.fixture
def shot_file(tmp_path):
    """Return a shot file whose focus differs in each frame."""
    path = tmp_path / "s.heatlens.json"
    write_shot(path, shot_of(write_plates(tmp_path / "plates")))
    return path


def test_export_sends_lens_of_each_frame(monkeypatch, shot_file, tmp_path):
    received = []
    monkeypatch.setattr(RingSources, "add_sample", lambda self, sample: received.append(sample))
    with LensReceiver(parse_ring_address("opentrackio://:0")) as receiver:
        words = ("-o", str(tmp_path / "o.####.exr"), "--send", str(receiver.address))
        for _ in range(2):  # the second time all frames are there already
            assert main(["export", str(shot_file), *words]) == 0
        end = time.monotonic() + PATIENCE_S
        while len(received) < 2 * len(FRAMES) and time.monotonic() < end:
            time.sleep(0.01)
    first_samples, second_samples = received[: len(FRAMES)], received[len(FRAMES) :]
    focus_m = [sample.focus_distance_m for sample in first_samples]
    assert focus_m == sorted(focus_m) and (focus_m[0], focus_m[-1]) == (0.9, 3.0)
    assert [sample.timecode.frames for sample in first_samples] == [frame % 24 for frame in FRAMES]
    assert second_samples == first_samples


def test_export_sends_lens_with_timecode_of_shot(monkeypatch, shot_file, tmp_path):
    write_shot(shot_file, read_shot(shot_file).with_start_timecode("10:00:00:00"))
    received = []
    monkeypatch.setattr(LensSender, "send", lambda self, sample: received.append(sample))
    words = ("-o", str(tmp_path / "o.####.exr"), "--send", "opentrackio")
    assert main(["export", str(shot_file), *words]) == 0
    timecodes = [str(sample.timecode) for sample in received]
    assert timecodes == [f"10:00:00:{number:02}" for number in range(len(FRAMES))]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--send", "osc://:9000"), "a camera can only be sent as OpenTrackIO"),
        (("--send", "opentrackio", "--submit", "openjd"), "--submit renders none"),
    ],
)
def test_export_refuses_impossible_send_before_rendering(
    capsys, shot_file, tmp_path, words, message
):
    out = tmp_path / "o"
    assert main(["export", str(shot_file), "-o", str(out / "o.####.exr"), *words]) == 2
    assert message in capsys.readouterr().err
    assert not out.exists()
