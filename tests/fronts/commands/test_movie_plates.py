"""Movies on the command line: one frame, a range, a shot, and what a farm is given of them."""

from pathlib import Path

import numpy as np
import pytest

from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import planned
from heatlens.deliver.farm.inputs import files_beside
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
    """Return a movie, and one with its depth."""
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
    beside = ("--depth", depth, *DEPTH, *LENS)
    return run(capsys, "export", source, "-o", out, *beside, *BLUR, *words)


def test_a_frame_that_is_rendered_is_that_of_the_export(tmp_path, clip, capsys):
    colors, depths = clip
    export(capsys, colors, depths, tmp_path / "all.####.exr", "--frames", "2-4")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"all.000{frame}.exr" for frame in (2, 3, 4)
    ]
    beside = ("--depth", depths, *DEPTH, *LENS, *BLUR)
    pictures = []
    for frame in (2, 3, 4):
        out = tmp_path / "one.exr"
        run(capsys, "render", colors, "--frame", frame, "-o", out, *beside)
        pictures.append(pixels(out))
        assert np.array_equal(pictures[-1], pixels(tmp_path / f"all.000{frame}.exr"))
    assert not np.array_equal(pictures[0], pictures[1])
    (header,) = read_headers(tmp_path / "all.0003.exr")
    assert str(timecode_of(header)) == "10:00:00:02"


def test_frames_are_counted_from_the_first_frame_that_is_given(tmp_path, clip, capsys):
    colors, depths = clip
    export(capsys, colors, depths, tmp_path / "a.####.exr", "--frames", 3)
    first = ("--first-frame", 1001, "--frames", 1003)
    export(capsys, colors, depths, tmp_path / "b.####.exr", *first)
    assert np.array_equal(pixels(tmp_path / "a.0003.exr"), pixels(tmp_path / "b.1003.exr"))


def test_an_export_goes_on_and_notices_another_count(tmp_path, clip, capsys):
    colors, depths = clip
    out = tmp_path / "a.####.exr"
    for part in ("1-2", "1-6"):
        said = export(capsys, colors, depths, out, "--frames", part)
    assert "4 frames written, 2 were finished before" in said
    whole = tmp_path / "b.####.exr"
    export(capsys, colors, depths, whole)
    for frame in range(1, COUNT + 1):
        mine, other = (Path(str(it).replace("####", f"{frame:04}")) for it in (out, whole))
        assert np.array_equal(pixels(mine), pixels(other))
    said = export(capsys, f"{colors}@2", depths, out, "--frames", "3")  # frame 3 is another one
    assert "1 frame written" in said


def test_a_shot_has_frames_and_rate_of_its_movie(tmp_path, clip, capsys):
    colors, depths = clip
    shot_path = tmp_path / "s.heatlens.json"
    run(capsys, "shot", "new", colors, "-o", shot_path, "--depth", depths, *DEPTH, *LENS)
    shot = read_shot(shot_path)
    assert shot.frames is not None and (shot.frames.first, shot.frames.last) == (1, COUNT)
    assert shot.frames_per_second == 25.0 and Path(shot.source or "").samefile(colors)
    job = ExportJob(shot, (1, 2, 3), parse_output(tmp_path / "f.####.exr"))
    assert set(files_beside(planned(job))) == {colors, depths}


def test_an_export_never_replaces_the_movie_that_it_reads(clip, capsys):
    colors, depths = clip
    before = colors.read_bytes()
    beside = ("--depth", depths, *DEPTH, *LENS, *BLUR)
    said = stderr_of_run(capsys, 2, "export", colors, "-o", colors, *beside, "--overwrite")
    assert "is an input of this export" in said and colors.read_bytes() == before


def test_a_frame_that_the_movie_does_not_have_is_one_sentence(tmp_path, clip, capsys):
    words = ("render", clip[0], "--frame", 99, "-o", tmp_path / "o.exr", *LENS)
    said = stderr_of_run(capsys, 2, *words)
    assert said.endswith("has no frame 99: there are 1-6.")


def test_a_frame_of_a_numbered_sequence_can_be_rendered(tmp_path, capsys):
    pattern = write_plates(tmp_path / "plates", (1001, 1002))
    out, named = tmp_path / "o.exr", tmp_path / "n.exr"
    lens = ("--f-stop", 2, "--focus-distance", 1)
    assert "--frame N" in stderr_of_run(capsys, 2, "render", pattern, "-o", out, *lens)
    run(capsys, "render", pattern, "--frame", 1002, "-o", out, *lens, *BLUR)
    run(capsys, "render", pattern.replace("####", "1002"), "-o", named, *lens, *BLUR)
    assert np.array_equal(pixels(out), pixels(named))


def test_info_tells_what_a_movie_holds(clip, capsys):
    assert main(["info", str(clip[0])]) == 0
    told = capsys.readouterr().out
    assert "6 frames at 25 a second, Apple ProRes" in told and "timecode 10:00:00:00" in told
