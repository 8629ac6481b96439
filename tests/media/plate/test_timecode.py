"""Test timecode of plates: reading, counting, and its output in movies and frames."""

import json
import shutil
import subprocess

import numpy as np
import OpenEXR
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.timecode import Timecode
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.timecode import exr_timecode, timecode_of
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file

LENS = ["--focal-length", 50, "--sensor-width", 36, "--f-stop", 8, "--focus-distance", 3]
DROP = st.sampled_from([(30, True), (60, True), (24, False), (25, False), (30, False)])


@st.composite
def timecodes(draw):
    rate, drop = draw(DROP)
    code = Timecode(*(draw(st.integers(0, most)) for most in (23, 59, 59, rate - 1)), drop)
    is_dropped = drop and code.minutes % 10 and not code.seconds and code.frames < rate // 15
    return (Timecode(code.hours, code.minutes, 1, code.frames, drop) if is_dropped else code), rate


@given(timecodes(), st.integers(-(10**7), 10**7))
def test_timecode_later_and_back_is_unchanged(timecode, frames):
    code, rate = timecode
    assert code.add_frames(frames, rate).add_frames(-frames, rate) == code
    assert code.add_frames(0, rate) == code


@given(timecodes())
def test_timecodes_of_adjacent_frames_differ_and_read_back(timecode):
    code, rate = timecode
    assert code.add_frames(1, rate) != code and timecode_of({"timecode": str(code)}) == code
    exr_value = exr_timecode(code)
    assert timecode_of({"timeCode": exr_value}) == (code if code.frames < 30 else None)


@pytest.mark.parametrize(
    ("code", "frames", "rate", "expected"),
    [
        ("00:00:59;29", 1, 29.97, "00:01:00;02"),
        ("00:09:59;29", 1, 29.97, "00:10:00;00"),
        ("00:00:00;00", 17982, 29.97, "00:10:00;00"),  # ten minutes of the clock
        ("00:00:59;59", 1, 59.94, "00:01:00;04"),
        ("23:59:59:23", 1, 24, "00:00:00:00"),
        ("01:00:00:00", -1, 23.976, "00:59:59:23"),
    ],
)
def test_timecode_later_matches_examples_of_the_standard(code, frames, rate, expected):
    assert str(timecode_of({"timecode": code}).add_frames(frames, rate)) == expected


@pytest.mark.parametrize("value", ["25:00:00:00", "1:2:3", "", 7, None, "00:61:00:00"])
def test_timecode_of_rejects_impossible_text(value):
    assert timecode_of({"timecode": value}) is None


def write_frames(folder, *frames):
    first = Timecode(hours=1, minutes=0, seconds=0, frames=0)
    depth = np.linspace(2, 6, 32 * 48, dtype="f4").reshape(32, 48)
    for frame in frames:
        code = exr_timecode(first.add_frames(frame - 1001, 24))
        write_file(folder / f"p.{frame}.exr", rgb(32, 48) | {"Z": depth}, timeCode=code)
    return folder / "p.####.exr"


def test_exported_frames_have_timecode_and_held_ones_continue(tmp_path, capsys):
    plates = write_frames(tmp_path, 1001, 1002, 1004)
    words = ["export", plates, "-o", tmp_path / "o" / "o.####.exr", "--missing", "hold", *LENS]
    stderr_of_run(capsys, 0, *words, "--method", "pyramid")
    for frame, expected in ((1001, "01:00:00:00"), (1003, "01:00:00:02"), (1004, "01:00:00:03")):
        header = read_parts(tmp_path / "o" / f"o.{frame}.exr")[0][0]
        assert isinstance(header["timeCode"], OpenEXR.TimeCode)
        assert str(timecode_of(header)) == expected


@pytest.mark.parametrize("suffix", [".mov", ".mp4"])
@pytest.mark.parametrize("first", [1001, 1003])
def test_exported_movie_has_timecode_track(tmp_path, capsys, suffix, first):
    av = pytest.importorskip("av")
    plates = write_frames(tmp_path, 1001, 1002, 1003, 1004)
    out = tmp_path / f"o{suffix}"
    words = ["export", plates, "-o", out, "--frames", f"{first}-1004", *LENS]
    stderr_of_run(capsys, 0, *words, "--method", "pyramid")
    expected = f"01:00:00:0{first - 1001}"
    with av.open(str(out)) as movie:
        tracks = [stream for stream in movie.streams if stream.type == "data"]
        assert [track.metadata["timecode"] for track in tracks] == [expected]
        assert sum(1 for _ in movie.decode(video=0)) == 1005 - first
    if shutil.which("ffprobe"):
        command = ["ffprobe", "-v", "error", "-show_streams", "-of", "json", str(out)]
        streams = json.loads(subprocess.check_output(command))["streams"]
        assert [s["codec_tag_string"] for s in streams if s["codec_type"] == "data"] == ["tmcd"]


def test_exported_movie_omits_timecode_of_another_rate(tmp_path, capsys):
    av = pytest.importorskip("av")
    code = exr_timecode(Timecode(hours=1, minutes=0, seconds=0, frames=29))
    depth = np.linspace(2, 6, 32 * 48, dtype="f4").reshape(32, 48)
    plates = write_file(tmp_path / "p.exr", rgb(32, 48) | {"Z": depth}, timeCode=code)
    out = tmp_path / "o.mov"
    stderr_of_run(capsys, 0, "export", plates, "-o", out, *LENS, "--method", "pyramid")
    with av.open(str(out)) as movie:
        assert [stream.type for stream in movie.streams] == ["video"]
