"""`heatlens shot new --follow`: a focus that follows a thing of plates or an object of a scene."""

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
WALK_M = {1: 3.0, 2: 3.5, 3: None, 4: 4.5}


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walk")
    for frame, distance_m in WALK_M.items():
        matte_plate(folder / f"walk.{frame:04d}.exr", distance_m)
    return folder / "walk.####.exr"


def made(capsys, tmp_path, *words):
    out = tmp_path / "s.heatlens.json"
    said = stderr_of_run(capsys, 0, "shot", "new", *words, "-o", out)
    return read_shot(out), said


def test_follow_makes_the_mark_and_the_focus(plates, tmp_path, capsys):
    shot, said = made(capsys, tmp_path, plates, *LENS, "--follow", "A=cryptomatte:hero")
    assert shot.marks == (MatteMark("A", "cryptomatte:hero"),)
    for frame, distance_m in {**WALK_M, 3: 3.9375}.items():
        lens = shot.lens_at(frame)
        assert abs(1 / lens.focus_distance_m - 1 / distance_m) <= 0.51 * sharp_dioptres(lens)
    assert "hidden" in said and "frame" in said and "3" in said


def test_follow_names_a_mark_that_is_made_beside_it(plates, tmp_path, capsys):
    marks = ("--mark", "A=objectId:7", "--mark", "B=2m")
    shot, _ = made(capsys, tmp_path, plates, *LENS, *marks, "--follow", "A")
    new = ("--overwrite", plates, *LENS)
    other, _ = made(capsys, tmp_path, *new, "--follow", "A=cryptomatte:hero")
    assert shot.curves == other.curves
    still, _ = made(capsys, tmp_path, *new, *marks, "--follow", "B")
    assert still.lens_at(1).focus_distance_m == still.lens_at(4).focus_distance_m == 2


def test_the_nearest_part_of_a_thing_is_followed(plates, tmp_path, capsys):
    shot, _ = made(capsys, tmp_path, plates, *LENS, "--follow", "A=nearest:cryptomatte:hero")
    assert shot.marks == (MatteMark("A", "cryptomatte:hero", MattePart.NEAREST),)


def test_an_object_of_a_scene_is_followed(tmp_path, capsys):
    scene = write_scene(tmp_path / "scene.glb")
    shot, _ = made(capsys, tmp_path, scene, "--f-stop", "1.4", "--follow", "A=object:near")
    assert shot.marks == (ObjectMark("A", "near"),)
    for frame, distance_m in {1: 3.0, 13: 4.0, 25: 5.0}.items():
        lens = shot.lens_at(frame)
        assert abs(1 / lens.focus_distance_m - 1 / distance_m) <= 0.51 * sharp_dioptres(lens)


@pytest.mark.parametrize(
    ("words", "told"),
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
def test_what_cannot_be_followed_is_refused(plates, tmp_path, capsys, words, told):
    out = tmp_path / "s.heatlens.json"
    said = stderr_of_run(capsys, 2, "shot", "new", plates, *LENS, *words, "-o", out)
    assert told in said and not out.exists()


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    folder, walk = tmp_path_factory.mktemp("tracked"), Walk(post=(160.0, 190.0))
    for frame in range(1, walk.frames + 1):
        walk.write(folder / f"card.{frame:04d}.exr", frame)
    return walk, folder / "card.####.exr"


def test_a_tracked_surface_is_followed_and_kept_in_the_shot(walk, tmp_path, capsys):
    card, plates = walk
    x, y = card.pixel(1)
    words = (plates, *LENS, "--follow", f"A=track:{x:.0f},{y:.0f}@1")
    shot, said = made(capsys, tmp_path, *words)
    (mark,) = shot.marks
    assert mark.clicks == (Click(1, round(x), round(y)),)
    assert len(mark.places) == card.frames and "hidden" in said
    for frame in range(1, card.frames + 1):
        lens = shot.lens_at(frame)
        off = abs(1 / lens.focus_distance_m - 1 / card.at(frame)[2])
        assert off <= 0.51 * sharp_dioptres(lens), frame
    assert main(["shot", "show", str(tmp_path / "s.heatlens.json")]) == 0
    assert "surface at pixel" in capsys.readouterr().out


def test_a_focus_that_is_not_measured_yet_is_told_without_a_value(tmp_path, capsys):
    words = (write_plates(tmp_path / "in"), "--frames", "1001-1001", "--f-stop", "1.4")
    _, said = made(capsys, tmp_path, *words, "--follow", "A@16,9")
    assert "focus 1 m" not in said and "focus on a mark (--follow)" in said
    assert "over 1 frame with 1 key." in said
