"""Test that exported movies keep the sound of their frames to the sample, or warn why not."""

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
    """Return white noise (N, 2), which matches itself at no other lag."""
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


def decoded_sound(path) -> np.ndarray | None:
    """Return the decoded sound, (N, 2); None without a track."""
    with av.open(str(path)) as container:
        if not container.streams.audio:
            return None
        resampler = av.AudioResampler("s16", "stereo", HERTZ)
        pieces = [it for frame in container.decode(audio=0) for it in resampler.resample(frame)]
        return np.concatenate([it.to_ndarray().reshape(-1, 2) for it in pieces])


@pytest.mark.parametrize(("first", "last"), [(1, COUNT), (4, 9)])
def test_movie_sound_has_exactly_the_samples_of_its_frames(capsys, tmp_path, clip, first, last):
    export(capsys, clip, tmp_path / "a.mov", "--frames", f"{first}-{last}")
    expected = SOUND[(first - 1) * PER_FRAME : last * PER_FRAME]
    np.testing.assert_array_equal(decoded_sound(tmp_path / "a.mov"), expected)


def test_aac_sound_has_no_delay(capsys, tmp_path, clip):
    """White noise correlates with itself only at lag zero."""
    export(capsys, clip, tmp_path / "a.mp4")
    decoded = decoded_sound(tmp_path / "a.mp4")[: len(SOUND), 0].astype(float)
    expected = SOUND[: len(decoded), 0].astype(float)
    across = np.correlate(decoded[2000:20000], expected[3000:19000], "valid")
    assert np.argmax(across) == 1000


def test_movie_from_parts_with_sound_equals_whole_movie(capsys, tmp_path, clip):
    export(capsys, clip, tmp_path / "whole.mov")
    for part in ("1-5", "6-12"):
        export(capsys, clip, tmp_path / "a.mov", "--part", part)
    export(capsys, clip, tmp_path / "a.mov")
    assert (tmp_path / "a.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()


def test_mono_sound_is_resampled_to_stereo_48_khz(capsys, tmp_path, clip):
    source = tmp_path / "b.mov"
    with av.open(str(clip[0])) as input_movie, av.open(str(source), "w") as output_movie:
        picture = output_movie.add_stream_from_template(input_movie.streams.video[0])
        track = output_movie.add_stream("pcm_s16le", 44_100, layout="mono")
        for packet in input_movie.demux(video=0):
            if packet.size:
                packet.stream = picture
                output_movie.mux(packet)
        tone = 9000 * np.sin(2 * np.pi * 440 * np.arange(22_050) / 44_100)
        frame = av.AudioFrame.from_ndarray(tone.astype(np.int16)[None], "s16", "mono")
        frame.sample_rate, frame.pts = 44_100, 0
        output_movie.mux([*track.encode(frame), *track.encode(None)])
    export(capsys, (source, clip[1]), tmp_path / "a.mov")
    sound = decoded_sound(tmp_path / "a.mov")
    assert abs(len(sound) - COUNT * PER_FRAME) <= 1
    expected = 9000 * np.sin(2 * np.pi * 440 * np.arange(len(sound)) / HERTZ)
    assert np.abs(sound[500:-500, 1] / sound.max() - expected[500:-500] / 9000).max() < 0.02


@pytest.mark.parametrize(
    ("words", "why"),
    [(("--frames", "1-11x2"), "frames are left out too"), (("--fps", 25), "its frame rate is")],
)
def test_export_warns_why_sound_is_left_out(capsys, tmp_path, clip, words, why):
    message = export(capsys, clip, tmp_path / "a.mov", *words)
    assert f"The sound of {clip[0]} is left out" in message and why in message
    assert decoded_sound(tmp_path / "a.mov") is None


def test_silent_movie_stays_silent(capsys, tmp_path, clip):
    source = write_movie(tmp_path / "b.mov", ramps(COUNT))
    assert "sound" not in export(capsys, (source, clip[1]), tmp_path / "a.mov")
    assert decoded_sound(tmp_path / "a.mov") is None


def test_short_sound_is_padded_with_silence(capsys, tmp_path, clip):
    source = write_movie(tmp_path / "b.mov", ramps(COUNT), sound=SOUND[: 5 * PER_FRAME])
    export(capsys, (source, clip[1]), tmp_path / "a.mov")
    sound = decoded_sound(tmp_path / "a.mov")
    np.testing.assert_array_equal(sound[: 5 * PER_FRAME], SOUND[: 5 * PER_FRAME])
    assert len(sound) == COUNT * PER_FRAME and not sound[5 * PER_FRAME :].any()


def test_movie_of_cut_has_sound_of_shots_and_silent_gaps(capsys, tmp_path, clip):
    source, depth = clip
    shots = (
        ReelShot(name="b", source=str(source), frames=FrameRange(7, 9)),
        ReelShot(name="a", source=str(source), frames=FrameRange(1, 2)),
    )
    reel = tmp_path / "cut.heatreel.json"
    write_reel(reel, Reel("cut", shots, RATE, None, ((1, 2),)))
    export(capsys, (reel, depth), tmp_path / "a.mov")
    silence = np.zeros((2 * PER_FRAME, 2), np.int16)
    expected = [SOUND[6 * PER_FRAME : 9 * PER_FRAME], silence, SOUND[: 2 * PER_FRAME]]
    np.testing.assert_array_equal(decoded_sound(tmp_path / "a.mov"), np.concatenate(expected))


def test_export_leaves_out_damaged_sound_with_warning(capsys, tmp_path, clip):
    source = tmp_path / "b.mp4"
    export(capsys, clip, source)
    with av.open(str(source)) as container:
        packet_ranges = [(it.pos, it.size) for it in container.demux(audio=0) if it.size]
    data = bytearray(source.read_bytes())
    for start, size in packet_ranges[4:]:
        data[start : start + size] = b"\xff" * size
    source.write_bytes(data)
    assert "because it is damaged" in export(capsys, (source, clip[1]), tmp_path / "a.mov")
    assert decoded_sound(tmp_path / "a.mov") is None
