"""Test `heatlens shot`: the written file, the printed text and the exit code."""

import json
import math
import re

import pytest

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Interpolation, Scale
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.command_line import CAMERA, channels, folder_of
from support.exr_files import write_file

LENS = ("--focal-length", "50", "--sensor-width", "36", "--f-stop", "1.3")
PULL = ("--key", "focus@1001=0.94", "--key", "focus@1024=3.83")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Work in a temporary folder and return it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def new_shot(capsys, *words: str, plate: str = "plate.####.exr") -> tuple[Shot, str]:
    """Run `heatlens shot new`. Return the written shot and the messages on stderr."""
    assert main(["shot", "new", plate, "-o", "s.heatlens.json", *words]) == 0
    captured = capsys.readouterr()
    assert captured.out == "s.heatlens.json\n"
    assert all(line.startswith("heatlens: ") for line in captured.err.splitlines())
    return read_shot("s.heatlens.json"), captured.err


def run_refused(capsys, folder, *words: str) -> str:
    """Run a command that fails with code 2 and changes no file. Return its message on stderr."""
    files_before = folder_of(folder / "s.heatlens.json")
    assert main(["shot", *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) <= 2
    assert folder_of(folder / "s.heatlens.json") == files_before
    return captured.err


def run_shot_show(capsys, *words: str) -> str:
    assert main(["shot", "show", "s.heatlens.json", *words]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def write_frames(folder, *frames: int) -> None:
    for frame in frames:
        write_file(folder / f"plate.{frame}.exr", channels(), **CAMERA)


def test_shot_new_sets_focus_pull_without_plates(capsys, folder):
    shot, message = new_shot(capsys, *LENS, *PULL)
    assert shot.lens == Lens(50.0, 1.3, 0.94, 36.0)
    assert shot.source == str(folder / "plate.####.exr")
    assert shot.curves.focus_distance_m.keys == (Key(1001, 0.94), Key(1024, 3.83))
    assert shot.span == FrameRange(1001, 1024)
    assert "the plate has no files yet" in message
    for frame in range(1001, 1025):
        u = (frame - 1001) / 23
        dioptres = 1 / 0.94 + (1 / 3.83 - 1 / 0.94) * u * u * (3 - 2 * u)
        lens = shot.lens_at(frame)
        assert lens.focus_distance_m == pytest.approx(1 / dioptres, rel=1e-12)
        assert (lens.f_stop, lens.focal_length_mm) == (1.3, 50.0)


def test_shot_new_stores_every_option(capsys):
    words = (
        *("--focal-length", "50", "--filmback", "Super 35", "--f-stop", "2", "--squeeze", "1.8"),
        *("--key", "focus@1001=6'3\":linear", "--key", "focus@1024.5=inf:hold"),
        *("--key", "f-stop@1010=2.8", "--key", "focal-length@1010=85", "--key", "squeeze@1=1.5"),
        *("--mark", "A=6'3\"", "--mark", "sky=inf", "--mark", "B@960,540.5"),
        *("--frames", "1001-1100", "--in-out", "1005-1020", "--fps", "25"),
        *("--close-focus", "45cm", "--bokeh", "heat", "--quality", "draft", "--layers", "3"),
        *("--proxy", "0.5", "--depth-convention", "inverse", "--scene-unit", "cm"),
    )
    shot, message = new_shot(capsys, *words)
    linear, hold = Interpolation.LINEAR, Interpolation.HOLD
    keys = shot.curves.focus_distance_m.keys
    near = pytest.approx(1.905)
    assert [(key.frame, key.value, key.interpolation) for key in keys] == [
        (1001, near, linear),
        (1024.5, math.inf, hold),
    ]
    assert shot.curves.f_stop.keys == (Key(1010, 2.8),)
    assert shot.curves.focal_length_mm.keys == (Key(1010, 85),)
    assert shot.curves.squeeze.keys == (Key(1, 1.5),)
    assert shot.marks == (
        DistanceMark("A", keys[0].value),
        DistanceMark("sky", math.inf),
        PointMark("B", 960, 540.5),
    )
    assert (shot.frames, shot.in_out) == (FrameRange(1001, 1100), FrameRange(1005, 1020))
    assert (shot.frames_per_second, shot.lens.close_focus_m) == (25.0, 0.45)
    assert shot.lens.sensor_width_mm == 24.89
    assert shot.defocus == DefocusSettings(Bokeh.HEAT, Quality.DRAFT, 3, 0.5)
    assert (shot.plate_options.depth_convention, shot.plate_options.scene_unit_m) == (
        "inverse",
        0.01,
    )
    assert re.findall(r"(--[a-z-]+) is not used", message) == [
        "--f-stop",
        "--focal-length",
        "--squeeze",
    ]


def test_shot_new_takes_frames_and_lens_from_plates(capsys, folder):
    write_frames(folder, 1001, 1002, 1004)
    shot, message = new_shot(capsys, "--focus-distance", "inf")
    assert shot.lens == Lens(50.0, 2.0, math.inf, 36.0)
    assert shot.frames == FrameRange(1001, 1004)
    assert shot.source == str(folder / "plate.####.exr")
    assert "lens: 50 mm, f/2, focus inf\n" in message
    shot_of_frame, _ = new_shot(capsys, "--focus-at", "3,5", "--overwrite", plate="plate.1002.exr")
    assert (shot_of_frame.frames, shot_of_frame.source) == (shot.frames, shot.source)
    assert shot_of_frame.lens.focus_distance_m == 4.0  # column x is x + 1 metres away


def test_keys_replace_lens_values_missing_in_header(capsys, folder):
    write_file(folder / "still.exr", channels())
    words = ("--key", "f-stop@1=4", "--key", "focal-length@1=35", *PULL)
    shot, message = new_shot(capsys, *words, plate="still.exr")
    assert shot.lens == Lens(35.0, 4.0, 0.94, 36.0)
    assert shot.frames is None and shot.span == FrameRange(1, 1024)
    assert "assumed full frame" in message


def test_distance_interpolation_is_linear_in_meters(capsys):
    words = ("--key", "focus@0=2:linear", "--key", "focus@10=8")
    shot, _ = new_shot(capsys, *LENS, *words, "--focus-interpolation", "distance")
    assert shot.curves.focus_distance_m.scale is Scale.LINEAR
    assert shot.lens_at(5).focus_distance_m == pytest.approx(5.0)


def test_shot_new_warns_of_frames_below_close_focus(capsys):
    _, message = new_shot(capsys, *LENS, *PULL, "--close-focus", "1m")
    assert "1 m at frames 1001-1004" in message
    assert "1 m; nearer at frames 1001-1004" in run_shot_show(capsys)


def test_shot_new_replaces_existing_shot_only_with_overwrite(capsys, folder):
    new_shot(capsys, *LENS, *PULL)
    words = ("new", "plate.####.exr", "-o", "s.heatlens.json", *LENS, "--focus-distance", "2")
    assert "Replace it with --overwrite" in run_refused(capsys, folder, *words)
    assert new_shot(capsys, *words[4:], "--overwrite")[0].lens.focus_distance_m == 2.0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            (*LENS[:4], *PULL),
            "No file is called plate.####.exr. The folder holds no EXR file. With",
        ),
        ((*LENS, "--key", "focus@1001"), "--key takes PARAMETER@FRAME=VALUE"),
        ((*LENS, "--key", "zoom@1001=3"), "got 'zoom@1001=3'"),
        ((*LENS, "--key", "focus@x=3"), "got 'focus@x=3'"),
        ((*LENS, "--key", "focus@1=3:smoth"), "paths are hold, linear, smooth, bezier"),
        ((*LENS, "--key", "focus@1=near"), "'near' is not a distance"),
        ((*LENS, "--key", "focus@1=0.02"), "beyond the focal length of 50 mm, got 0.02 m"),
        ((*LENS, *PULL, "--key", "focus@1001=2"), "There are two keys at frame 1001: keep one."),
        (
            (*LENS, *PULL, "--key", "f-stop@1001=nan"),
            "f-stop must be between 0.001 and 1,000,000, got nan",
        ),
        ((*LENS, *PULL, "--key", "squeeze@5=3"), "squeeze must be 1 to 2"),
        ((*LENS, *PULL, "--mark", "A"), "--mark takes NAME=DISTANCE or NAME@X,Y; got 'A'"),
        ((*LENS, *PULL, "--mark", "A@5"), "--mark takes a pixel as NAME@X,Y, got 'A@5'"),
        ((*LENS, *PULL, "--mark", "A=1", "--mark", "A=2"), "Two marks are called A: rename one."),
        ((*LENS, *PULL, "--frames", "1100-1001"), "run backwards"),
        ((*LENS, *PULL, "--fps", "0"), "Frames per second must be above 0"),
        ((*LENS, *PULL, "-o", "s.json"), "must end in .heatlens.json"),
        ((*LENS, *PULL, "-o", "none/s.heatlens.json"), "does not exist"),
        (
            (*LENS, "--key", "focus@1=inf", "--focus-interpolation", "distance"),
            "use the scale of dioptres for infinity",
        ),
    ],
)
def test_shot_new_rejects_wrong_options(capsys, folder, words, sentence):
    message = run_refused(capsys, folder, "new", "plate.####.exr", "-o", "s.heatlens.json", *words)
    assert sentence in message


def test_shot_show_prints_table_of_lens_at_every_frame(capsys):
    shot, _ = new_shot(capsys, *LENS, *PULL, "--mark", "A=0.94", "--mark", "B@3,4")
    text = run_shot_show(capsys)
    rows = [line.split() for line in text.splitlines()]
    frames = [row for row in rows if row and re.fullmatch(r"1\d{3}", row[0])]
    assert [int(row[0]) for row in frames] == list(range(1001, 1025))
    for row in frames:
        assert float(row[1]) == pytest.approx(
            shot.lens_at(int(row[0])).focus_distance_m, abs=5.1e-4
        )
    assert ["focus", "distance", "1001", "0.94", "m", "smooth"] in rows
    assert ["A", "0.94", "m"] in rows and ["B", "pixel", "3,4"] in rows
    table = text.split("\n\n")[-1].splitlines()
    assert len({len(line) for line in table}) == 1  # aligned


def test_shot_show_unit_ft_prints_feet(capsys):
    new_shot(capsys, *LENS, "--focus-distance", "6'3\"", "--mark", "A=10ft")
    text = run_shot_show(capsys, "--unit", "ft")
    assert "6'3\"" in text and "10'0\"" in text and " any" in text


def test_shot_show_json_holds_file_and_lens_of_every_frame(capsys, folder):
    shot, _ = new_shot(
        capsys, *LENS, "--key", "focus@1=2", "--key", "focus@3=inf", "--mark", "A=inf"
    )
    facts = json.loads(run_shot_show(capsys, "--json"))
    file = json.loads((folder / "s.heatlens.json").read_text())
    assert {name: facts[name] for name in file} == file
    focuses = [entry["focus_distance_m"] for entry in facts["lens_at"]]
    assert focuses == [2, shot.lens_at(2).focus_distance_m, "inf"]
    assert facts["lens_at"][2]["far_limit_m"] == "inf"


def test_shot_show_escapes_undecodable_file_name(capsys, folder):
    write_shot("s.heatlens.json", Shot(Lens(50, 1.3, 2, 36), source="pl\udce4te.####.exr"))
    assert "pl\\udce4te.####.exr" in run_shot_show(capsys)


def test_shot_show_reports_damaged_or_missing_file(capsys, folder):
    new_shot(capsys, *LENS, *PULL)
    path = folder / "s.heatlens.json"
    path.write_text(path.read_text().replace('"value": 3.83', '"valeu": 3.83'))
    message = run_refused(capsys, folder, "show", "s.heatlens.json")
    assert "s.heatlens.json: keys.focus_distance_m[1]: unknown entry 'valeu'" in message
    assert "is not there" in run_refused(capsys, folder, "show", "none.heatlens.json")


def test_shot_new_doubts_lens_by_depths_of_first_plate(capsys, folder):
    """The doubt comes from the depths of the first plate, if all keys are doubtful."""
    write_frames(folder, 1001, 1002)
    lens_options = ("--focal-length", "50", "--sensor-width", "36", "--f-stop", "2")
    _, message = new_shot(capsys, *lens_options, "--focus-distance", "2240", "--overwrite")
    assert "farther than every surface" in message and "--focus-distance 2240mm" in message
    _, message = new_shot(
        capsys, *lens_options, "--key", "focus@1001=3", "--key", "focus@1002=2240", "--overwrite"
    )
    assert "farther" not in message
    words = ("--focus-distance", "2240", "--strict", "--overwrite")
    assert "farther than every surface" in run_refused(
        capsys, folder, "new", "plate.####.exr", "-o", "s.heatlens.json", *lens_options, *words
    )


def test_shot_new_prints_doubt_about_lens_once(capsys, folder):
    write_frames(folder, 1001)
    _, message = new_shot(capsys, "--focus-distance", "2240")
    assert message.count("farther than every surface") == 1
