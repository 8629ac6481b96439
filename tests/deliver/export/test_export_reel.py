"""Test `heatlens export` and `heatlens reel` of a cut: shots, one movie, and follow-up commands."""

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
from support.exports import files_in, refused_export_message, shot_of, write_plates

LENS = ("--f-stop", "1.4", "--focus-distance", "2", "--quality", "draft")
GRADE = Grade((1.5, 1.0, 0.7), (0.02, 0.0, -0.02), (1.0, 1.1, 0.9), 0.5)
FIRST_RANGE, SECOND_RANGE = FrameRange(1002, 1003), FrameRange(1004, 1005)


@pytest.fixture
def reel(tmp_path):
    """Write a reel: plates, an empty frame, and a shot file."""
    source, shot = write_plates(tmp_path / "p"), tmp_path / "s2.heatlens.json"
    write_shot(shot, shot_of(source))
    path = tmp_path / "cut.heatreel.json"
    shots = (
        ReelShot(name="s1", source=source, frames=FIRST_RANGE),
        ReelShot(name="s2", source=str(shot), frames=SECOND_RANGE),
    )
    write_reel(path, Reel("cut", shots, 25.0, "01:00:00:00", ((1, 1),)))
    return path


@pytest.fixture
def plates_reel(tmp_path):
    source, path = write_plates(tmp_path / "p"), tmp_path / "cut.heatreel.json"
    write_reel(
        path,
        Reel("cut", (ReelShot("s1", source, FIRST_RANGE), ReelShot("s2", source, SECOND_RANGE))),
    )
    return path


def export(reel, out, *words) -> None:
    assert main(["export", str(reel), "-o", str(out), *map(str, words)]) == 0


def test_reel_export_of_shot_equals_export_of_shot_alone(tmp_path, plates_reel):
    out = tmp_path / "out" / "{shot}" / "{shot}.####.exr"
    export(plates_reel, out, *LENS)
    source = tmp_path / "p" / "plate.####.exr"
    export(source, tmp_path / "alone.####.exr", *LENS, "--fps", 24, "--frames", "1004-1005")
    assert sorted(files_in(tmp_path / "out" / "s2")) == ["s2.1004.exr", "s2.1005.exr"]
    for frame in SECOND_RANGE:
        (reel_part,) = read_parts(tmp_path / "out" / "s2" / f"s2.{frame}.exr")
        (single_part,) = read_parts(tmp_path / f"alone.{frame}.exr")
        assert all(np.array_equal(reel_part[1][name], single_part[1][name]) for name in "RGB")


def test_handles_are_limited_to_available_frames(tmp_path, plates_reel, capsys):
    export(plates_reel, tmp_path / "o" / "{shot}.####.exr", *LENS, "--handles", 2)
    file_names = sorted(files_in(tmp_path / "o"))
    assert [name for name in file_names if name.startswith("s1")] == [
        f"s1.{frame}.exr" for frame in range(1001, 1006)
    ]
    assert "s1: the handles are shorter, as only frames 1001-1005 exist" in capsys.readouterr().err


def test_movie_of_cut_has_frames_in_order_black_gap_and_timecode(tmp_path, reel):
    """The empty frame between the shots is black; shots keep their own pull."""
    movie = tmp_path / "cut.mov"
    export(reel, movie)
    with av.open(str(movie)) as container:
        assert container.streams.video[0].average_rate == 25
        cut_frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(cut_frames) == FIRST_RANGE.count + 1 + SECOND_RANGE.count
    assert [int(frame.max()) < 5 for frame in cut_frames] == [False, False, True, False, False]
    assert str(timecode_of(picture_header(movie))) == "01:00:00:00"
    assert not (tmp_path / "cut.mov.frames").exists()
    for frame, index in ((1002, 0), (1005, 4)):
        words = ("--frames", str(frame), "--fps", "25")
        source = tmp_path / "p" / "plate.####.exr" if index == 0 else tmp_path / "s2.heatlens.json"
        export(source, tmp_path / "one.mov", *words, "--force")
        with av.open(str(tmp_path / "one.mov")) as container:
            single_frame = next(container.decode(video=0)).to_ndarray(format="rgb24")
        assert np.array_equal(single_frame, cut_frames[index])


def test_movie_of_cut_reuses_frames_of_stopped_export(tmp_path, reel, monkeypatch):
    """Frames kept beside the movie are not rendered again, and a finished movie is kept."""
    movie = tmp_path / "cut.mov"
    with monkeypatch.context() as patch, pytest.raises(ZeroDivisionError):
        patch.setattr("heatlens.deliver.export.cut._join_frames", lambda cut: 1 / 0)
        from heatlens.fronts.commands.command_parser import build_parser
        from heatlens.fronts.commands.export import _export_shot, _open_frames, _print_notes
        from heatlens.fronts.commands.reel_export import ReelActions, export_reel

        args = build_parser(["export"]).parse_args(["export", str(reel), "-o", str(movie)])
        work = ReelActions(_print_notes, _export_shot, lambda shots: None, _open_frames)
        export_reel(args, work)
    kept_frame_times = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("frame.*.exr")}
    assert len(kept_frame_times) == FIRST_RANGE.count + SECOND_RANGE.count and not movie.exists()
    with monkeypatch.context() as patch:
        patch.setattr("heatlens.deliver.export.run.FrameRendering.render", None)
        export(reel, movie)
        time_before = movie.stat().st_mtime_ns
        export(reel, movie)
    assert movie.stat().st_mtime_ns == time_before


def test_after_export_command_gets_report_of_each_shot(tmp_path, reel):
    report_path = tmp_path / "told"
    export(reel, tmp_path / "o" / "{shot}.####.exr", "--after-export", f"cat >> '{report_path}'")
    first_report, second_report = map(json.loads, report_path.read_text().splitlines())
    assert (first_report["shot"], first_report["frames"], first_report["timecode"]) == (
        "s1",
        [1002, 1003],
        None,
    )
    assert second_report["files"] == [
        str(tmp_path / "o" / f"s2.{frame}.exr") for frame in SECOND_RANGE
    ]
    shot = read_shot(tmp_path / "s2.heatlens.json")
    assert second_report["lens"]["focus_distance_m"] == [
        shot.lens_at(frame).focus_distance_m for frame in SECOND_RANGE
    ]


def test_failing_after_export_command_fails_export_but_keeps_frames(tmp_path, capsys):
    source, out = write_plates(tmp_path / "p"), tmp_path / "o.####.exr"
    words = (*LENS, "--frames", "1001", "--after-export", "exit 3")
    assert main(["export", source, "-o", str(out), *words]) == 2
    message = capsys.readouterr().err
    assert "exit 3" in message and "code 3" in message and (tmp_path / "o.1001.exr").exists()


def test_edit_out_refers_to_exported_frames(tmp_path, reel):
    out = tmp_path / "o" / "{shot}.####.exr"
    export(reel, out, "--handles", 1, "--edit-out", tmp_path / "new.otio")
    from heatlens.core.model.shot.reel import EditOptions
    from heatlens.media.documents.edit_file import read_edit

    edit = read_edit(tmp_path / "new.otio", EditOptions())
    assert [shot.frames for shot in edit.shots] == [FIRST_RANGE, SECOND_RANGE]
    assert [shot.source for shot in edit.shots] == [
        str(tmp_path / "o" / f"s{n}.####.exr") for n in (1, 2)
    ]
    assert edit.gaps == ((1, 1),)


@pytest.mark.parametrize(("words", "message"), [((), "{shot}"), (("--frames", "3"), "--frames")])
def test_reel_export_refuses_options_for_single_shot(tmp_path, reel, capsys, words, message):
    out = tmp_path / ("o.####.exr" if not words else "{shot}.####.exr")
    assert message in refused_export_message(capsys, reel, out, *words)
    assert not list(tmp_path.glob("*.exr"))


def test_reel_export_names_missing_media_before_writing(tmp_path, capsys):
    path = tmp_path / "cut.heatreel.json"
    gone = ReelShot("gone", "", None, ("its media are missing: /nowhere/x",))
    write_reel(path, Reel("cut", (ReelShot("s1", write_plates(tmp_path / "p")), gone)))
    assert "/nowhere/x" in refused_export_message(capsys, path, tmp_path / "{shot}.####.exr", *LENS)
    assert main(["info", str(path)]) == 1


def test_reel_of_changed_edit_keeps_keys_of_existing_shots(tmp_path, plates_reel, capsys):
    out, shots = tmp_path / "r.heatreel.json", tmp_path / "shots"
    words = ["-o", str(out), "--shots", str(shots), "--f-stop", "1.4", "--mark", "B=3m"]
    assert main(["reel", str(plates_reel), *words]) == 0
    shot_path = shots / "s1.heatlens.json"
    first_shot = read_shot(shot_path)
    assert (first_shot.in_out, first_shot.lens.f_stop, first_shot.marks[0].name) == (
        FIRST_RANGE,
        1.4,
        "B",
    )
    shot_with_keys = replace(shot_of(first_shot.source), in_out=FIRST_RANGE)
    write_shot(shot_path, shot_with_keys)
    reel_before = read_reel(plates_reel)
    # the edit is changed: its first shot becomes longer
    longer_shot = replace(reel_before.shots[0], frames=FrameRange(1001, 1006))
    write_reel(plates_reel, replace(reel_before, shots=(longer_shot, *reel_before.shots[1:])))
    capsys.readouterr()
    assert main(["reel", str(plates_reel), *words]) == 0
    assert "s1.heatlens.json was there, and keeps its own lens" in capsys.readouterr().err
    assert read_shot(shot_path) == replace(shot_with_keys, in_out=longer_shot.frames)
    assert read_reel(out).shots[0].source == str(shot_path)


def test_slurm_script_runs_after_export_command_last(tmp_path, capsys):
    source = write_plates(tmp_path / "p")
    words = (*LENS, "--submit", "slurm", "--chunk", "2", "--memory", "1")
    export(source, tmp_path / "o.####.exr", *words, "--after-export", "echo 'done' $HOME")
    script = capsys.readouterr().out
    last = [line for line in script.splitlines() if "afterok" in line]
    assert len(last) == 1 and "--after-export=" in script
    subprocess.run(["sh", "-n"], input=script, text=True, check=True)


def test_grade_of_edit_applies_to_png_but_not_to_exr(tmp_path, plates_reel):
    """The grade of the edit acts like the option `--cdl`."""
    reel = read_reel(plates_reel)
    graded = replace(reel, shots=tuple(replace(shot, grade=GRADE) for shot in reel.shots))
    source = tmp_path / "p" / "plate.####.exr"
    for name, suffix in (("pictures", "png"), ("light", "exr")):
        write_reel(plates_reel, graded)
        export(plates_reel, tmp_path / name / f"{{shot}}.####.{suffix}", *LENS)
        write_reel(plates_reel, reel)
        export(plates_reel, tmp_path / name / "plain" / f"{{shot}}.####.{suffix}", *LENS)
    words = (*LENS, "--frames", "1002", "--fps", 24)
    export(source, tmp_path / "alone.####.png", *words, "--cdl", str(GRADE))
    pictures, light = tmp_path / "pictures", tmp_path / "light"
    graded_picture = pixels_of(pictures / "s1.1002.png")
    assert np.array_equal(graded_picture, pixels_of(tmp_path / "alone.1002.png"))
    assert np.abs(graded_picture - pixels_of(pictures / "plain" / "s1.1002.png")).max() > 10
    for folder in (light, light / "plain"):
        assert (folder / "s1.1002.exr").exists()
    (graded_part,), (plain_part,) = (
        read_parts(folder_of_part / "s1.1002.exr") for folder_of_part in (light, light / "plain")
    )
    assert all(np.array_equal(graded_part[1][name], plain_part[1][name]) for name in "RGB")


def test_grade_of_shot_is_used_unless_cdl_option_replaces_it(tmp_path):
    source, shot = write_plates(tmp_path / "p"), tmp_path / "s.heatlens.json"
    write_shot(shot, replace(shot_of(source), grade=GRADE))
    assert read_shot(shot).grade == GRADE
    reel = tmp_path / "cut.heatreel.json"
    write_reel(
        reel, Reel("cut", (ReelShot("s", str(shot), FIRST_RANGE, grade=Grade((9.0, 9.0, 9.0))),))
    )
    words = ("--frames", "1002", "--quality", "draft")
    export(shot, tmp_path / "own.####.png", *words)
    export(shot, tmp_path / "none.####.png", *words, "--cdl", "none")
    export(reel, tmp_path / "{shot}.####.png", "--quality", "draft")
    own_picture = pixels_of(tmp_path / "own.1002.png")
    assert np.abs(own_picture - pixels_of(tmp_path / "none.1002.png")).max() > 10
    assert np.array_equal(own_picture, pixels_of(tmp_path / "s.1002.png"))


def test_reel_of_changed_edit_copies_grade_into_shot_file(tmp_path, plates_reel):
    reel_path, shots = tmp_path / "made.heatreel.json", tmp_path / "shots"
    main_words = ["reel", str(plates_reel), "-o", str(reel_path), "--shots", str(shots), *LENS[:4]]
    assert main(main_words) == 0
    path = shots / "s1.heatlens.json"
    assert read_shot(path).grade is None
    reel = read_reel(plates_reel)
    write_reel(plates_reel, replace(reel, shots=(replace(reel.shots[0], grade=GRADE),)))
    assert main(main_words) == 0
    assert read_shot(path).grade == GRADE


def pixels_of(path) -> np.ndarray:
    return np.asarray(Image.open(path), np.int32)


# Messages


def test_message_common_to_all_shots_is_printed_once(capsys, tmp_path):
    sources = [write_plates(tmp_path / name) for name in "abc"]
    path = tmp_path / "cut.heatreel.json"
    shots = (ReelShot(f"s{index}", source, FIRST_RANGE) for index, source in enumerate(sources))
    write_reel(path, Reel("cut", tuple(shots)))
    export(path, tmp_path / "out" / "{shot}" / "n.####.exr", *LENS)
    lines = capsys.readouterr().err.splitlines()
    for topic in (" depth: ", " lens: "):
        (line,) = (it for it in lines if topic in it)
        assert line.startswith(f"heatlens: all 3 shots:{topic}")


def test_message_of_single_shot_has_no_shot_count(capsys, tmp_path):
    source, path = write_plates(tmp_path / "p"), tmp_path / "cut.heatreel.json"
    write_reel(path, Reel("cut", (ReelShot(name="s1", source=source, frames=FIRST_RANGE),)))
    export(path, tmp_path / "out" / "{shot}" / "n.####.exr", *LENS)
    message = capsys.readouterr().err
    assert "\nheatlens: depth: " in f"\n{message}" and "shots: " not in message


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
@pytest.mark.parametrize("position", [0, 1])
def test_reel_command_rejects_source_that_is_no_shot(capsys, tmp_path, name, expected, position):
    if not name.startswith("there_is_none"):
        (tmp_path / name).write_text("<fcpxml/>")
    words = [write_plates(tmp_path / "p")]
    words.insert(position, str(tmp_path / name))
    assert main(["reel", *words, "-o", str(tmp_path / "made.heatreel.json")]) == 2
    message = capsys.readouterr().err
    assert name in message and expected in message and "Traceback" not in message
    assert not (tmp_path / "made.heatreel.json").exists()


def test_reel_command_accepts_plates_scene_and_shot_file(tmp_path):
    plates, shot = write_plates(tmp_path / "p"), tmp_path / "s.heatlens.json"
    write_shot(shot, shot_of(plates))
    path = tmp_path / "made.heatreel.json"
    assert main(["reel", plates, "demo", str(shot), "-o", str(path)]) == 0
    assert len(read_reel(path).shots) == 3
