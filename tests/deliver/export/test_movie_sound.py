"""The sound of a movie goes with its frames, exact to a sample, or a sentence says why not."""

import av
import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.media.documents.reel_file import write_reel
from support.command_line import stderr_of_run
from support.movies import ramps, write_movie

COUNT, RATE, HERTZ = 12, 24, 48_000
PER_FRAME = HERTZ // RATE
READ = ("--depth-convention", "normalized", "--near", 1, "--far", 3, "--method", "heat")
LENS = ("--focal-length", 50, "--sensor-width", 36, "--f-stop", 2, "--focus-distance", 1.2)


def noise(seconds: float) -> np.ndarray:
    """Return sound that is nowhere like itself."""
    random = np.random.default_rng(7)
    return random.integers(-9000, 9000, (round(seconds * HERTZ), 2)).astype(np.int16)


SOUND = noise(COUNT / RATE)


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clip")
    depth = write_movie(folder / "z.mkv", ramps(COUNT), "FFV1", pixel_format="gray16le")
    return write_movie(folder / "clip.mov", ramps(COUNT), sound=SOUND), depth


def export(capsys, clip, out, *words):
    source, depth = clip
    return stderr_of_run(
        capsys, 0, "export", source, "-o", out, "--depth", depth, *READ, *LENS, *words
    )


def heard(path) -> np.ndarray | None:
    """Return the decoded sound, (N, 2); None without a track."""
    with av.open(str(path)) as container:
        if not container.streams.audio:
            return None
        turned = av.AudioResampler("s16", "stereo", HERTZ)
        pieces = [it for frame in container.decode(audio=0) for it in turned.resample(frame)]
        return np.concatenate([it.to_ndarray().reshape(-1, 2) for it in pieces])


@pytest.mark.parametrize(("first", "last"), [(1, COUNT), (4, 9)])
def test_every_sample_of_the_frames_is_there(capsys, tmp_path, clip, first, last):
    export(capsys, clip, tmp_path / "a.mov", "--frames", f"{first}-{last}")
    wanted = SOUND[(first - 1) * PER_FRAME : last * PER_FRAME]
    np.testing.assert_array_equal(heard(tmp_path / "a.mov"), wanted)


def test_aac_is_in_step(capsys, tmp_path, clip):
    """White noise is like itself only where the lag is nothing."""
    export(capsys, clip, tmp_path / "a.mp4")
    found = heard(tmp_path / "a.mp4")[: len(SOUND), 0].astype(float)
    wanted = SOUND[: len(found), 0].astype(float)
    across = np.correlate(found[2000:20000], wanted[3000:19000], "valid")
    assert np.argmax(across) == 1000


def test_a_movie_of_parts_sounds_like_the_whole(capsys, tmp_path, clip):
    export(capsys, clip, tmp_path / "whole.mov")
    for part in ("1-5", "6-12"):
        export(capsys, clip, tmp_path / "a.mov", "--part", part)
    export(capsys, clip, tmp_path / "a.mov")
    assert (tmp_path / "a.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()


def test_sound_in_mono_at_another_rate_is_turned(capsys, tmp_path, clip):
    source = tmp_path / "b.mov"
    with av.open(str(clip[0])) as given, av.open(str(source), "w") as made:
        picture = made.add_stream_from_template(given.streams.video[0])
        track = made.add_stream("pcm_s16le", 44_100, layout="mono")
        for packet in given.demux(video=0):
            if packet.size:
                packet.stream = picture
                made.mux(packet)
        tone = 9000 * np.sin(2 * np.pi * 440 * np.arange(22_050) / 44_100)
        frame = av.AudioFrame.from_ndarray(tone.astype(np.int16)[None], "s16", "mono")
        frame.sample_rate, frame.pts = 44_100, 0
        made.mux([*track.encode(frame), *track.encode(None)])
    export(capsys, (source, clip[1]), tmp_path / "a.mov")
    found = heard(tmp_path / "a.mov")
    assert abs(len(found) - COUNT * PER_FRAME) <= 1
    wanted = 9000 * np.sin(2 * np.pi * 440 * np.arange(len(found)) / HERTZ)
    assert np.abs(found[500:-500, 1] / found.max() - wanted[500:-500] / 9000).max() < 0.02


@pytest.mark.parametrize(
    ("words", "why"),
    [(("--frames", "1-11x2"), "frames are left out too"), (("--fps", 25), "its frame rate is")],
)
def test_what_cannot_go_along_is_said(capsys, tmp_path, clip, words, why):
    said = export(capsys, clip, tmp_path / "a.mov", *words)
    assert f"The sound of {clip[0]} is left out" in said and why in said
    assert heard(tmp_path / "a.mov") is None


def test_a_silent_movie_stays_silent(capsys, tmp_path, clip):
    source = write_movie(tmp_path / "b.mov", ramps(COUNT))
    assert "sound" not in export(capsys, (source, clip[1]), tmp_path / "a.mov")
    assert heard(tmp_path / "a.mov") is None


def test_sound_that_ends_early_is_followed_by_silence(capsys, tmp_path, clip):
    source = write_movie(tmp_path / "b.mov", ramps(COUNT), sound=SOUND[: 5 * PER_FRAME])
    export(capsys, (source, clip[1]), tmp_path / "a.mov")
    found = heard(tmp_path / "a.mov")
    np.testing.assert_array_equal(found[: 5 * PER_FRAME], SOUND[: 5 * PER_FRAME])
    assert len(found) == COUNT * PER_FRAME and not found[5 * PER_FRAME :].any()


def test_a_cut_has_the_sound_of_its_shots_and_silence_between(capsys, tmp_path, clip):
    source, depth = clip
    shots = (
        ReelShot("b", str(source), FrameRange(7, 9)),
        ReelShot("a", str(source), FrameRange(1, 2)),
    )
    reel = tmp_path / "cut.heatreel.json"
    write_reel(reel, Reel("cut", shots, RATE, None, ((1, 2),)))
    export(capsys, (reel, depth), tmp_path / "a.mov")
    silence = np.zeros((2 * PER_FRAME, 2), np.int16)
    wanted = [SOUND[6 * PER_FRAME : 9 * PER_FRAME], silence, SOUND[: 2 * PER_FRAME]]
    np.testing.assert_array_equal(heard(tmp_path / "a.mov"), np.concatenate(wanted))


def test_damaged_sound_is_left_out(capsys, tmp_path, clip):
    source = tmp_path / "b.mp4"
    export(capsys, clip, source)
    with av.open(str(source)) as container:
        places = [(it.pos, it.size) for it in container.demux(audio=0) if it.size]
    data = bytearray(source.read_bytes())
    for at, size in places[4:]:
        data[at : at + size] = b"\xff" * size
    source.write_bytes(data)
    assert "because it is damaged" in export(capsys, (source, clip[1]), tmp_path / "a.mov")
    assert heard(tmp_path / "a.mov") is None
