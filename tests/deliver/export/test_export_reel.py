"""`heatlens export` and `heatlens reel` of a cut: every shot, one movie, and what follows."""

import json
import subprocess
from dataclasses import replace

import av
import numpy as np
import pytest
from PIL import Image

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.reel_file import read_reel, write_reel
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.timecode import timecode_of
from heatlens.media.plate.parts.picture_parts import picture_header
from support.exports import files_in, refused, shot_of, write_plates

LENS = ("--f-stop", "1.4", "--focus-distance", "2", "--quality", "draft")
GRADE = Grade((1.5, 1.0, 0.7), (0.02, 0.0, -0.02), (1.0, 1.1, 0.9), 0.5)
FIRST, SECOND = FrameRange(1002, 1003), FrameRange(1004, 1005)


@pytest.fixture
def reel(tmp_path):
    """Write a reel: plates, an empty frame, and a shot file."""
    source, shot = write_plates(tmp_path / "p"), tmp_path / "s2.heatlens.json"
    write_shot(shot, shot_of(source))
    path = tmp_path / "cut.heatreel.json"
    shots = (ReelShot("s1", source, FIRST), ReelShot("s2", str(shot), SECOND))
    write_reel(path, Reel("cut", shots, 25.0, "01:00:00:00", ((1, 1),)))
    return path


@pytest.fixture
def plates_alone(tmp_path):
    source, path = write_plates(tmp_path / "p"), tmp_path / "cut.heatreel.json"
    write_reel(path, Reel("cut", (ReelShot("s1", source, FIRST), ReelShot("s2", source, SECOND))))
    return path


def export(reel, out, *words) -> None:
    assert main(["export", str(reel), "-o", str(out), *map(str, words)]) == 0


def test_every_shot_is_what_an_export_of_it_alone_is(tmp_path, plates_alone):
    out = tmp_path / "out" / "{shot}" / "{shot}.####.exr"
    export(plates_alone, out, *LENS)
    source = tmp_path / "p" / "plate.####.exr"
    export(source, tmp_path / "alone.####.exr", *LENS, "--fps", 24, "--frames", "1004-1005")
    assert sorted(files_in(tmp_path / "out" / "s2")) == ["s2.1004.exr", "s2.1005.exr"]
    for frame in SECOND:
        (one,) = read_parts(tmp_path / "out" / "s2" / f"s2.{frame}.exr")
        (alone,) = read_parts(tmp_path / f"alone.{frame}.exr")
        assert all(np.array_equal(one[1][name], alone[1][name]) for name in "RGB")


def test_handles_are_as_long_as_the_media(tmp_path, plates_alone, capsys):
    export(plates_alone, tmp_path / "o" / "{shot}.####.exr", *LENS, "--handles", 2)
    made = sorted(files_in(tmp_path / "o"))
    assert [name for name in made if name.startswith("s1")] == [
        f"s1.{frame}.exr" for frame in range(1001, 1006)
    ]
    assert "s1: there are no handles but those of frames 1001-1005" in capsys.readouterr().err


def test_a_movie_of_the_cut_has_its_frames_in_order_and_its_timecode(tmp_path, reel):
    """The empty frame between the shots is black; shots keep their own pull."""
    movie = tmp_path / "cut.mov"
    export(reel, movie)
    with av.open(str(movie)) as container:
        assert container.streams.video[0].average_rate == 25
        shown = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(shown) == FIRST.count + 1 + SECOND.count
    assert [int(frame.max()) < 5 for frame in shown] == [False, False, True, False, False]
    assert str(timecode_of(picture_header(movie))) == "01:00:00:00"
    assert not (tmp_path / "cut.mov.frames").exists()
    for frame, at in ((1002, 0), (1005, 4)):
        words = ("--frames", str(frame), "--fps", "25")
        source = tmp_path / "p" / "plate.####.exr" if at == 0 else tmp_path / "s2.heatlens.json"
        export(source, tmp_path / "one.mov", *words, "--force")
        with av.open(str(tmp_path / "one.mov")) as container:
            alone = next(container.decode(video=0)).to_ndarray(format="rgb24")
        assert np.array_equal(alone, shown[at])


def test_a_movie_of_the_cut_goes_on_where_it_was_stopped(tmp_path, reel, monkeypatch):
    """Frames that are kept beside it are not made again, and a finished movie is left alone."""
    movie = tmp_path / "cut.mov"
    with monkeypatch.context() as patch, pytest.raises(ZeroDivisionError):
        patch.setattr("heatlens.deliver.export.cut._join", lambda cut: 1 / 0)
        from heatlens.fronts.commands.command_parser import build_parser
        from heatlens.fronts.commands.export import _export_shot, _say_before, _steps
        from heatlens.fronts.commands.reel_export import ReelWork, export_reel

        args = build_parser(["export"]).parse_args(["export", str(reel), "-o", str(movie)])
        work = ReelWork(_say_before, _export_shot, lambda shots: None, _steps)
        export_reel(args, work)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("frame.*.exr")}
    assert len(kept) == FIRST.count + SECOND.count and not movie.exists()
    with monkeypatch.context() as patch:
        patch.setattr("heatlens.deliver.export.run.FrameRendering.rendered", None)
        export(reel, movie)
        before = movie.stat().st_mtime_ns
        export(reel, movie)
    assert movie.stat().st_mtime_ns == before


def test_a_command_hears_of_every_shot(tmp_path, reel):
    told = tmp_path / "told"
    export(reel, tmp_path / "o" / "{shot}.####.exr", "--after-export", f"cat >> '{told}'")
    one, two = map(json.loads, told.read_text().splitlines())
    assert (one["shot"], one["frames"], one["timecode"]) == ("s1", [1002, 1003], None)
    assert two["files"] == [str(tmp_path / "o" / f"s2.{frame}.exr") for frame in SECOND]
    shot = read_shot(tmp_path / "s2.heatlens.json")
    assert two["lens"]["focus_distance_m"] == [
        shot.lens_at(frame).focus_distance_m for frame in SECOND
    ]


def test_a_command_that_fails_fails_the_export_and_leaves_the_frames(tmp_path, capsys):
    source, out = write_plates(tmp_path / "p"), tmp_path / "o.####.exr"
    words = (*LENS, "--frames", "1001", "--after-export", "exit 3")
    assert main(["export", source, "-o", str(out), *words]) == 2
    said = capsys.readouterr().err
    assert "exit 3" in said and "code 3" in said and (tmp_path / "o.1001.exr").exists()


def test_the_edit_that_is_written_names_the_new_frames(tmp_path, reel):
    out = tmp_path / "o" / "{shot}.####.exr"
    export(reel, out, "--handles", 1, "--edit-out", tmp_path / "new.otio")
    from heatlens.media.documents.edit_file import EditOptions, read_edit

    back = read_edit(tmp_path / "new.otio", EditOptions())
    assert [shot.frames for shot in back.shots] == [FIRST, SECOND]
    assert [shot.source for shot in back.shots] == [
        str(tmp_path / "o" / f"s{n}.####.exr") for n in (1, 2)
    ]
    assert back.gaps == ((1, 1),)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "{shot}"),
        (("--frames", "3"), "--frames"),
    ],
)
def test_options_that_are_about_one_shot_are_refused(tmp_path, reel, capsys, words, told):
    out = tmp_path / ("o.####.exr" if not words else "{shot}.####.exr")
    assert told in refused(capsys, reel, out, *words)
    assert not list(tmp_path.glob("*.exr"))


def test_missing_media_are_named_before_anything_is_made(tmp_path, capsys):
    path = tmp_path / "cut.heatreel.json"
    gone = ReelShot("gone", "", None, ("its media are missing: /nowhere/x",))
    write_reel(path, Reel("cut", (ReelShot("s1", write_plates(tmp_path / "p")), gone)))
    assert "/nowhere/x" in refused(capsys, path, tmp_path / "{shot}.####.exr", *LENS)
    assert main(["info", str(path)]) == 1


def test_a_changed_edit_keeps_the_keys_of_shots_that_are_still_there(tmp_path, plates_alone):
    out, shots = tmp_path / "r.heatreel.json", tmp_path / "shots"
    words = ["-o", str(out), "--shots", str(shots), "--f-stop", "1.4", "--mark", "B=3m"]
    assert main(["reel", str(plates_alone), *words]) == 0
    own = shots / "s1.heatlens.json"
    made = read_shot(own)
    assert (made.in_out, made.lens.f_stop, made.marks[0].name) == (FIRST, 1.4, "B")
    pulled = replace(shot_of(made.source), in_out=FIRST)
    write_shot(own, pulled)
    before = read_reel(plates_alone)
    longer = replace(before.shots[0], frames=FrameRange(1001, 1006))
    write_reel(plates_alone, replace(before, shots=(longer, *before.shots[1:])))
    assert main(["reel", str(plates_alone), *words]) == 0
    assert read_shot(own) == replace(pulled, in_out=longer.frames)
    assert read_reel(out).shots[0].source == str(own)


def test_a_job_for_a_farm_ends_with_the_command(tmp_path, capsys):
    source = write_plates(tmp_path / "p")
    words = (*LENS, "--submit", "slurm", "--chunk", "2", "--memory", "1")
    export(source, tmp_path / "o.####.exr", *words, "--after-export", "echo 'done' $HOME")
    script = capsys.readouterr().out
    last = [line for line in script.splitlines() if "afterok" in line]
    assert len(last) == 1 and "--after-export=" in script
    subprocess.run(["sh", "-n"], input=script, text=True, check=True)


def test_the_grade_of_the_edit_is_in_pictures_and_not_in_exr(tmp_path, plates_alone):
    """As that of the option is; a shot file of the reel keeps its own."""
    reel = read_reel(plates_alone)
    graded = replace(reel, shots=tuple(replace(shot, grade=GRADE) for shot in reel.shots))
    source = tmp_path / "p" / "plate.####.exr"
    for name, suffix in (("pictures", "png"), ("light", "exr")):
        write_reel(plates_alone, graded)
        export(plates_alone, tmp_path / name / f"{{shot}}.####.{suffix}", *LENS)
        write_reel(plates_alone, reel)
        export(plates_alone, tmp_path / name / "plain" / f"{{shot}}.####.{suffix}", *LENS)
    words = (*LENS, "--frames", "1002", "--fps", 24)
    export(source, tmp_path / "alone.####.png", *words, "--cdl", str(GRADE))
    pictures, light = tmp_path / "pictures", tmp_path / "light"
    shown = pixels_of(pictures / "s1.1002.png")
    assert np.array_equal(shown, pixels_of(tmp_path / "alone.1002.png"))
    assert np.abs(shown - pixels_of(pictures / "plain" / "s1.1002.png")).max() > 10
    for folder in (light, light / "plain"):
        assert (folder / "s1.1002.exr").exists()
    (one,), (plain,) = (read_parts(at / "s1.1002.exr") for at in (light, light / "plain"))
    assert all(np.array_equal(one[1][name], plain[1][name]) for name in "RGB")


def test_the_shot_keeps_its_grade_unless_another_is_given(tmp_path):
    source, shot = write_plates(tmp_path / "p"), tmp_path / "s.heatlens.json"
    write_shot(shot, replace(shot_of(source), grade=GRADE))
    assert read_shot(shot).grade == GRADE
    reel = tmp_path / "cut.heatreel.json"
    write_reel(reel, Reel("cut", (ReelShot("s", str(shot), FIRST, grade=Grade((9.0, 9.0, 9.0))),)))
    words = ("--frames", "1002", "--quality", "draft")
    export(shot, tmp_path / "own.####.png", *words)
    export(shot, tmp_path / "none.####.png", *words, "--cdl", "none")
    export(reel, tmp_path / "{shot}.####.png", "--quality", "draft")
    own = pixels_of(tmp_path / "own.1002.png")
    assert np.abs(own - pixels_of(tmp_path / "none.1002.png")).max() > 10
    assert np.array_equal(own, pixels_of(tmp_path / "s.1002.png"))


def test_a_changed_edit_brings_its_grade_into_the_shot(tmp_path, plates_alone):
    made, shots = tmp_path / "made.heatreel.json", tmp_path / "shots"
    main_words = ["reel", str(plates_alone), "-o", str(made), "--shots", str(shots), *LENS[:4]]
    assert main(main_words) == 0
    path = shots / "s1.heatlens.json"
    assert read_shot(path).grade is None
    reel = read_reel(plates_alone)
    write_reel(plates_alone, replace(reel, shots=(replace(reel.shots[0], grade=GRADE),)))
    assert main(main_words) == 0
    assert read_shot(path).grade == GRADE


def pixels_of(path) -> np.ndarray:
    return np.asarray(Image.open(path), np.int32)


# What is said


def test_what_is_said_of_every_shot_is_said_once(capsys, tmp_path):
    sources = [write_plates(tmp_path / name) for name in "abc"]
    path = tmp_path / "cut.heatreel.json"
    shots = (ReelShot(f"s{at}", source, FIRST) for at, source in enumerate(sources))
    write_reel(path, Reel("cut", tuple(shots)))
    export(path, tmp_path / "out" / "{shot}" / "n.####.exr", *LENS)
    said = capsys.readouterr().err.splitlines()
    for begin in (" depth: ", " lens: "):
        (line,) = (it for it in said if begin in it)
        assert line.startswith(f"heatlens: all 3 shots:{begin}")


def test_what_is_said_of_one_shot_does_not_tell_a_count(capsys, tmp_path):
    source, path = write_plates(tmp_path / "p"), tmp_path / "cut.heatreel.json"
    write_reel(path, Reel("cut", (ReelShot("s1", source, FIRST),)))
    export(path, tmp_path / "out" / "{shot}" / "n.####.exr", *LENS)
    said = capsys.readouterr().err
    assert "\nheatlens: depth: " in f"\n{said}" and "shots: " not in said


WRONG = {
    "notes.txt": "is not an OpenEXR file",
    "cut.fcpxml": "it reads OpenTimelineIO",
    "old.avi": "it reads .mov",
    "there_is_none.exr": "there_is_none.exr",
    "there_is_none.glb": "is not there",
    "there_is_none.heatlens.json": "there_is_none.heatlens.json",
    "other.heatreel.json": "is a reel or an edit itself",
}


@pytest.mark.parametrize(("name", "expected"), WRONG.items())
@pytest.mark.parametrize("place", [0, 1])
def test_what_cannot_be_a_shot_makes_no_reel(capsys, tmp_path, name, expected, place):
    if not name.startswith("there_is_none"):
        (tmp_path / name).write_text("<fcpxml/>")
    words = [write_plates(tmp_path / "p")]
    words.insert(place, str(tmp_path / name))
    assert main(["reel", *words, "-o", str(tmp_path / "made.heatreel.json")]) == 2
    said = capsys.readouterr().err
    assert name in said and expected in said and "Traceback" not in said
    assert not (tmp_path / "made.heatreel.json").exists()


def test_a_reel_of_scenes_and_shots(tmp_path):
    plates, shot = write_plates(tmp_path / "p"), tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(plates))
    path = tmp_path / "made.heatreel.json"
    assert main(["reel", plates, "demo", str(shot), "-o", str(path)]) == 0
    assert len(read_reel(path).shots) == 3
