"""Test `heatlens shot new --follow`: focus keys that follow a matte, surface or scene object."""

import pytest

from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.marks.marks import MatteMark, MattePart, ObjectMark
from heatlens.core.model.marks.track_mark import Click
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from support.command_line import stderr_of_run
from support.exports import write_plates
from support.mattes import matte_plate
from support.session_files import write_scene
from support.walks import Walk

LENS = ("--focal-length", "50", "--sensor-width", "36", "--f-stop", "1.4")
HIDDEN_FRAME = 3
WALK_M = {1: 3.0, 2: 3.5, HIDDEN_FRAME: None, 4: 4.5}
# Largest error of a followed focus, as a share of the sharp range on one side of it. An eighth of
# the whole range is ignored, and leaving out keys adds as much; the rest is for rounding.
MOST_ERROR_SHARE = 0.51


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walk")
    for frame, distance_m in WALK_M.items():
        matte_plate(folder / f"walk.{frame:04d}.exr", distance_m)
    return folder / "walk.####.exr"


def new_shot(capsys, tmp_path, *words):
    out = tmp_path / "s.heatlens.json"
    message = stderr_of_run(capsys, 0, "shot", "new", *words, "-o", out)
    return read_shot(out), message


def follows(shot, frame, distance_m):
    """Return whether the focus at a frame is as near to a distance as following it allows."""
    lens = shot.lens_at(frame)
    error_dioptres = abs(1 / lens.focus_distance_m - 1 / distance_m)
    return error_dioptres <= MOST_ERROR_SHARE * sharp_dioptres(lens)


def test_follow_adds_mark_and_focus_keys(plates, tmp_path, capsys):
    shot, message = new_shot(capsys, tmp_path, plates, *LENS, "--follow", "A=cryptomatte:hero")
    assert shot.marks == (MatteMark("A", "cryptomatte:hero"),)
    hidden_m = 2 / (1 / WALK_M[2] + 1 / WALK_M[4])  # in dioptres the mean of its neighbors
    for frame, distance_m in {**WALK_M, HIDDEN_FRAME: hidden_m}.items():
        assert follows(shot, frame, distance_m), frame
    assert f"A is hidden, or out of the picture, at frames {HIDDEN_FRAME}:" in message


def test_follow_accepts_name_of_mark_option(plates, tmp_path, capsys):
    marks = ("--mark", "A=objectId:7", "--mark", "B=2m")
    shot, _ = new_shot(capsys, tmp_path, plates, *LENS, *marks, "--follow", "A")
    new = ("--overwrite", plates, *LENS)
    matte_shot, _ = new_shot(capsys, tmp_path, *new, "--follow", "A=cryptomatte:hero")
    assert shot.curves == matte_shot.curves
    distance_shot, _ = new_shot(capsys, tmp_path, *new, *marks, "--follow", "B")
    assert (
        distance_shot.lens_at(1).focus_distance_m == distance_shot.lens_at(4).focus_distance_m == 2
    )


def test_follow_nearest_part_of_matte(plates, tmp_path, capsys):
    shot, _ = new_shot(capsys, tmp_path, plates, *LENS, "--follow", "A=nearest:cryptomatte:hero")
    assert shot.marks == (MatteMark("A", "cryptomatte:hero", MattePart.NEAREST),)


def test_follow_object_of_scene(tmp_path, capsys):
    scene = write_scene(tmp_path / "scene.glb")
    shot, _ = new_shot(capsys, tmp_path, scene, "--f-stop", "1.4", "--follow", "A=object:near")
    assert shot.marks == (ObjectMark("A", "near"),)
    for frame, distance_m in {1: 3.0, 13: 4.0, 25: 5.0}.items():
        assert follows(shot, frame, distance_m), frame


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--follow", "A"), "no such mark"),
        (("--follow", "A=cryptomatte:nobody"), "nobody"),
        (("--follow", "A=matte:nothing"), "nothing"),
        (("--follow", "A=hero:"), "cryptomatte:NAME"),
        (("--mark", "A=track:3,4", "--focus-distance", "2"), "track:X,Y@FRAME"),
        (("--mark", "A=track:3,4@99", "--focus-distance", "2"), "99"),
        (("--mark", "A=world:3,4", "--focus-distance", "2"), "world:X,Y,Z"),
        (("--follow", "A=world:3,4,5"), "worldToCamera"),
        (("--follow", "A=2m", "--key", "focus@1=3"), "--key"),
        (("--focus-distance", "2", "--follow-late", "3"), "--follow"),
        (("--follow", "A=2m", "--follow-ignores", "0.9"), "0.5"),
    ],
)
def test_follow_rejects_impossible_marks_and_options(plates, tmp_path, capsys, words, expected):
    out = tmp_path / "s.heatlens.json"
    message = stderr_of_run(capsys, 2, "shot", "new", plates, *LENS, *words, "-o", out)
    assert expected in message and not out.exists()


@pytest.fixture(scope="module")
def tracked_walk(tmp_path_factory):
    folder, walk = tmp_path_factory.mktemp("tracked"), Walk(post=(160.0, 190.0))
    for frame in range(1, walk.frames + 1):
        walk.write(folder / f"card.{frame:04d}.exr", frame)
    return walk, folder / "card.####.exr"


def test_follow_tracked_surface_stores_places_in_shot(tracked_walk, tmp_path, capsys):
    card, plates = tracked_walk
    x, y = card.pixel(1)
    words = (plates, *LENS, "--follow", f"A=track:{x:.0f},{y:.0f}@1")
    shot, message = new_shot(capsys, tmp_path, *words)
    (mark,) = shot.marks
    assert mark.clicks == (Click(frame=1, x_px=round(x), y_px=round(y)),)
    assert len(mark.places) == card.frames and "hidden" in message
    for frame in range(1, card.frames + 1):
        assert follows(shot, frame, distance_m=card.at(frame)[2]), frame
    assert main(["shot", "show", str(tmp_path / "s.heatlens.json")]) == 0
    assert "surface at pixel" in capsys.readouterr().out


def test_follow_message_names_mark_instead_of_focus_distance(tmp_path, capsys):
    words = (write_plates(tmp_path / "in"), "--frames", "1001-1001", "--f-stop", "1.4")
    _, message = new_shot(capsys, tmp_path, *words, "--follow", "A@16,9")
    assert "focus 1 m" not in message and "f/1.4, focus on a mark heatlens:" in message
    assert "over 1 frame with 1 key." in message
