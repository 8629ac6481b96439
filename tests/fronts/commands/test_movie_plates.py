"""Test movies as plates on the command line: single frames, ranges, shots and exports."""

from pathlib import Path

import numpy as np
import pytest

from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import plan_export
from heatlens.deliver.farm.inputs import input_files
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.timecode import timecode_of
from heatlens.media.plate.parts.header_read import read_headers
from support.command_line import stderr_of_run
from support.exports import write_plates
from support.movies import ramps, write_movie

COUNT = 6
BLUR = ("--quality", "draft")
DEPTH = ("--depth-convention", "normalized", "--near", 1, "--far", 3)
LENS = ("--focal-length", 50, "--sensor-width", 36, "--f-stop", 2, "--focus-distance", 1.2)


@pytest.fixture(scope="module")
def clip(tmp_path_factory) -> tuple[Path, Path]:
    """Write a color movie and a depth movie. Return their paths."""
    folder = tmp_path_factory.mktemp("clip")
    colors = write_movie(folder / "clip.mov", ramps(COUNT), timecode="10:00:00:00", rate=25)
    depths = write_movie(folder / "z.mkv", ramps(COUNT), "FFV1", pixel_format="gray16le")
    return colors, depths


def pixels(path: Path) -> np.ndarray:
    ((_, channels),) = read_parts(path)
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def run(capsys, *words: object) -> str:
    return stderr_of_run(capsys, 0, *words)


def export(capsys, source: object, depth: Path, out: object, *words: object) -> str:
    options = ("--depth", depth, *DEPTH, *LENS)
    return run(capsys, "export", source, "-o", out, *options, *BLUR, *words)


def test_render_and_export_of_movie_frame_are_equal(tmp_path, clip, capsys):
    colors, depths = clip
    export(capsys, colors, depths, tmp_path / "all.####.exr", "--frames", "2-4")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"all.000{frame}.exr" for frame in (2, 3, 4)
    ]
    options = ("--depth", depths, *DEPTH, *LENS, *BLUR)
    pictures = []
    for frame in (2, 3, 4):
        out = tmp_path / "one.exr"
        run(capsys, "render", colors, "--frame", frame, "-o", out, *options)
        pictures.append(pixels(out))
        assert np.array_equal(pictures[-1], pixels(tmp_path / f"all.000{frame}.exr"))
    assert not np.array_equal(pictures[0], pictures[1])
    (header,) = read_headers(tmp_path / "all.0003.exr")
    assert str(timecode_of(header)) == "10:00:00:02"


def test_first_frame_option_numbers_frames_of_movie(tmp_path, clip, capsys):
    colors, depths = clip
    export(capsys, colors, depths, tmp_path / "a.####.exr", "--frames", 3)
    first = ("--first-frame", 1001, "--frames", 1003)
    export(capsys, colors, depths, tmp_path / "b.####.exr", *first)
    assert np.array_equal(pixels(tmp_path / "a.0003.exr"), pixels(tmp_path / "b.1003.exr"))


def test_export_of_movie_resumes_and_notices_other_first_frame(tmp_path, clip, capsys):
    colors, depths = clip
    out = tmp_path / "a.####.exr"
    for frame_range in ("1-2", "1-6"):
        message = export(capsys, colors, depths, out, "--frames", frame_range)
    assert "4 frames written, 2 were finished before" in message
    whole = tmp_path / "b.####.exr"
    export(capsys, colors, depths, whole)
    for frame in range(1, COUNT + 1):
        resumed_path, whole_path = (
            Path(str(pattern).replace("####", f"{frame:04}")) for pattern in (out, whole)
        )
        assert np.array_equal(pixels(resumed_path), pixels(whole_path))
    message = export(capsys, f"{colors}@2", depths, out, "--frames", "3")  # frame 3 is another one
    assert "1 frame written" in message


def test_shot_new_takes_frames_and_rate_of_movie(tmp_path, clip, capsys):
    colors, depths = clip
    shot_path = tmp_path / "s.heatlens.json"
    run(capsys, "shot", "new", colors, "-o", shot_path, "--depth", depths, *DEPTH, *LENS)
    shot = read_shot(shot_path)
    assert shot.frames is not None and (shot.frames.first, shot.frames.last) == (1, COUNT)
    assert shot.frames_per_second == 25.0 and Path(shot.source or "").samefile(colors)
    job = ExportJob(shot, frames=(1, 2, 3), output=parse_output(tmp_path / "f.####.exr"))
    assert set(input_files(plan_export(job))) == {colors, depths}


def test_export_refuses_to_overwrite_input_movie(clip, capsys):
    colors, depths = clip
    bytes_before = colors.read_bytes()
    options = ("--depth", depths, *DEPTH, *LENS, *BLUR)
    message = stderr_of_run(capsys, 2, "export", colors, "-o", colors, *options, "--overwrite")
    assert "is an input of this export" in message and colors.read_bytes() == bytes_before


def test_render_rejects_frame_outside_movie(tmp_path, clip, capsys):
    words = ("render", clip[0], "--frame", 99, "-o", tmp_path / "o.exr", *LENS)
    message = stderr_of_run(capsys, 2, *words)
    assert message.endswith("has no frame 99: there are 1-6.")


def test_render_with_frame_option_renders_frame_of_sequence(tmp_path, capsys):
    pattern = write_plates(tmp_path / "plates", (1001, 1002))
    out, named_out = tmp_path / "o.exr", tmp_path / "n.exr"
    lens = ("--f-stop", 2, "--focus-distance", 1)
    assert "--frame N" in stderr_of_run(capsys, 2, "render", pattern, "-o", out, *lens)
    run(capsys, "render", pattern, "--frame", 1002, "-o", out, *lens, *BLUR)
    run(capsys, "render", pattern.replace("####", "1002"), "-o", named_out, *lens, *BLUR)
    assert np.array_equal(pixels(out), pixels(named_out))


def test_info_of_movie_gives_frames_rate_codec_and_timecode(clip, capsys):
    assert main(["info", str(clip[0])]) == 0
    text = capsys.readouterr().out
    assert "6 frames at 25 a second, Apple ProRes" in text and "timecode 10:00:00:00" in text
