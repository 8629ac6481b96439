"""Test live focus on a mark, which every command measures again after plates have changed."""

import csv
import json

import numpy as np
import pytest

import heatlens
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.focus.live_focus import Pursuit
from heatlens.core.model.shot.pull import bake_live_focus
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.render.source.live_focus import measure_followed_marks
from support.command_line import stderr_of_run
from support.exr_files import write_file
from support.mattes import HEIGHT, WIDTH, matte_plate
from support.session_files import write_scene

LENS = ("--focal-length", "50", "--sensor-width", "36", "--f-stop", "1.4")
WALK_M = {frame: 3.0 + 0.25 * frame for frame in range(1, 9)}
CARD_M = 6.0


def write_walk(folder, offset_m=0.0):
    for frame, distance_m in WALK_M.items():
        matte_plate(folder / f"walk.{frame:04d}.exr", distance_m + offset_m)
    return folder / "walk.####.exr"


@pytest.fixture
def shot(tmp_path, capsys):
    plates, out = write_walk(tmp_path), tmp_path / "s.heatlens.json"
    words = ("--follow", "A=cryptomatte:hero", "--live", "--follow-ignores", "0")
    message = stderr_of_run(capsys, 0, "shot", "new", plates, *LENS, *words, "-o", out)
    assert "follows A" in message and "live" in message
    return out


def focus_at(shot, frame):
    return shot.lens_at(frame).focus_distance_m


def test_live_follow_is_stored_without_keys(shot):
    live_shot = read_shot(shot)
    assert live_shot.curves.live.marks == ("A",) and live_shot.key_frames == ()
    for frame, distance_m in WALK_M.items():
        assert focus_at(live_shot, frame) == pytest.approx(distance_m, rel=1e-6)
    assert 1 / focus_at(live_shot, 1.5) == pytest.approx(
        0.5 / WALK_M[1] + 0.5 / WALK_M[2], rel=1e-6
    )
    assert focus_at(live_shot, -5) == focus_at(live_shot, 1) and focus_at(
        live_shot, 99
    ) == focus_at(live_shot, 8)


def test_live_follow_can_be_baked_to_keys(shot):
    live_shot = read_shot(shot)
    keyed = bake_live_focus(live_shot)
    assert keyed.curves.live is None and 2 <= len(keyed.curves.focus_distance_m.keys) < 8
    for frame in WALK_M:
        error = abs(1 / focus_at(keyed, frame) - 1 / focus_at(live_shot, frame))
        assert error <= 0.26 * sharp_dioptres(live_shot.lens_at(frame))


def test_live_follow_is_measured_again_after_plates_change(shot, tmp_path, capsys):
    table = tmp_path / "camera.csv"
    assert "changed" not in stderr_of_run(capsys, 0, "camera", shot, "-o", table)
    first = focus_column(table)
    assert first == pytest.approx(list(WALK_M.values()), rel=1e-4)
    write_walk(tmp_path, offset_m=0.5)
    assert "changed" in stderr_of_run(capsys, 0, "camera", shot, "-o", table)
    assert focus_column(table) == pytest.approx(np.add(first, 0.5), rel=1e-4)


def focus_column(path):
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    head = next(row for row in rows if any("focus" in cell.lower() for cell in row))
    column = next(i for i, cell in enumerate(head) if "focus" in cell.lower())
    return [float(row[column]) for row in rows[rows.index(head) + 1 :]]


def write_noise_plates(folder, distance_m):
    """Write noise plates of an object (id 7) at a growing distance in front of a wall."""
    rng = np.random.default_rng(5)
    for frame in (1, 2, 3):
        depth, ids = np.full((HEIGHT, WIDTH), 9.0, "f4"), np.zeros((HEIGHT, WIDTH), "u4")
        ids[6:18, 8:24], depth[6:18, 8:24] = 7, distance_m + frame / 4
        planes = {name: rng.random((HEIGHT, WIDTH)).astype("f4") for name in "RGB"}
        write_file(folder / f"n.{frame:04d}.exr", planes | {"Z": depth, "objectId": ids})
    return folder / "n.####.exr"


def test_export_and_python_use_live_focus_of_changed_plates(tmp_path, capsys):
    shot, out = tmp_path / "s.heatlens.json", tmp_path / "e.####.exr"
    words = ("--follow", "A=objectId:7", "--live", "--bokeh", "heat")
    stderr_of_run(
        capsys, 0, "shot", "new", write_noise_plates(tmp_path, 2.0), *LENS, *words, "-o", shot
    )
    exported_pictures = []
    for distance_m in (2.0, 1.0):
        write_noise_plates(tmp_path, distance_m)
        assert main(["export", str(shot), "-o", str(out)]) == 0
        (_, planes), *_ = read_parts(tmp_path / "e.0003.exr")
        exported_pictures.append(np.stack([planes[name] for name in "RGB"], axis=-1))
        with heatlens.open(shot) as source:
            picture = source.render(frame=3)[..., :3]
        np.testing.assert_array_equal(exported_pictures[-1], picture.astype(np.float16))
    # The thing is in focus at both distances, and what is around it is blurred otherwise.
    assert (
        np.abs(exported_pictures[0] - exported_pictures[1])[9:15, 12:20].max()
        < 0.01
        < np.abs(exported_pictures[0] - exported_pictures[1]).max()
    )


def test_follow_pull_goes_from_one_live_mark_to_another(shot, tmp_path, capsys):
    out = tmp_path / "p.heatlens.json"
    words = ("--follow", "A=cryptomatte:hero", "--mark", "B=cryptomatte:card", "--live")
    pull = ("--follow-pull", "B@3+3", "--follow-ignores", "0")
    stderr_of_run(
        capsys, 0, "shot", "new", tmp_path / "walk.####.exr", *LENS, *words, *pull, "-o", out
    )
    live_shot = read_shot(out)
    assert live_shot.curves.live.pursuits == (Pursuit("A"), Pursuit("B", 3, 3))
    for frame, part in {1: 0, 2: 0, 3: 0, 4: 7 / 27, 5: 20 / 27, 6: 1, 8: 1}.items():
        expected = (1 - part) / WALK_M[frame] + part / CARD_M
        assert 1 / focus_at(live_shot, frame) == pytest.approx(expected, rel=1e-6)


def test_live_follow_of_scene_object(tmp_path, capsys):
    scene, out = write_scene(tmp_path / "scene.glb"), tmp_path / "s.heatlens.json"
    words = ("--f-stop", "1.4", "--follow", "A=object:near", "--live")
    stderr_of_run(capsys, 0, "shot", "new", scene, *words, "-o", out)
    assert focus_at(read_shot(out), 13) == pytest.approx(4.0, abs=0.2)


def test_live_follow_of_single_picture_is_measured_again(tmp_path, capsys):
    plate, out = tmp_path / "still.exr", tmp_path / "s.heatlens.json"
    words = ("--follow", "A=cryptomatte:hero", "--live")
    stderr_of_run(capsys, 0, "shot", "new", matte_plate(plate, 3.0), *LENS, *words, "-o", out)
    assert focus_at(measure_followed_marks(read_shot(out)), 1) == pytest.approx(3.0)
    matte_plate(plate, 4.0)
    assert focus_at(measure_followed_marks(read_shot(out)), 1) == pytest.approx(4.0)


def test_strict_option_causes_no_new_measurement(shot, tmp_path, capsys):
    words = ("export", shot, "-o", tmp_path / "e.####.exr", "--frames", "1", "--strict")
    assert "changed" not in stderr_of_run(capsys, 0, *words)


def test_shot_show_describes_live_follow(shot, capsys):
    assert main(["shot", "show", str(shot)]) == 0
    assert "follows" in (text := capsys.readouterr().out) and "A, live" in text
    assert main(["shot", "show", str(shot), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["live_focus"]["pursuits"] == [
        {"mark": "A", "frames": 0}
    ]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--live",), "--follow"),
        (("--follow", "A=cryptomatte:hero", "--follow-pull", "B@3+3"), "no such mark"),
        (("--follow", "A=cryptomatte:hero", "--follow-pull", "B@3"), "B@1040+18"),
        (("--follow", "A=objectId:99", "--live"), "objectId is 99"),
    ],
)
def test_live_follow_rejects_impossible_options(shot, tmp_path, capsys, words, expected):
    plates, out = tmp_path / "walk.####.exr", tmp_path / "x.heatlens.json"
    lens = LENS if "--follow" in words else (*LENS, "--focus-distance", "3")
    assert expected in stderr_of_run(capsys, 2, "shot", "new", plates, *lens, *words, "-o", out)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda live: live["pursuits"].append({"mark": "Q", "start_frame": 4}), "1 frame or more"),
        (lambda live: live["pursuits"].clear(), "first without a start frame"),
        (lambda live: live["measured"][0].update(mark="C"), "measured"),
        (lambda live: live["measured"][0]["distances_m"].__setitem__(1, -1), "above 0"),
        (lambda live: live["follow"].update(ignored_part=9), "0 to 0.5"),
    ],
)
def test_damaged_live_focus_in_shot_file_is_reported(shot, capsys, change, expected):
    entries = json.loads(shot.read_text())
    change(entries["live_focus"])
    shot.write_text(json.dumps(entries))
    assert expected in stderr_of_run(capsys, 2, "shot", "show", shot)


def test_pull_sheet_lists_live_focus_at_turning_frames(shot, tmp_path, capsys):
    pytest.importorskip("jinja2")
    assert main(["shot", "sheet", str(shot), "-o", str(tmp_path / "pull.html")]) == 0
    with (tmp_path / "pull.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    frames = [int(row["frame"]) for row in rows]
    assert frames[0] == 1 and frames[-1] == 8
    for row in rows:
        focus_m = float(row["focus"].removesuffix(" m"))
        assert focus_m == pytest.approx(WALK_M[int(row["frame"])], abs=0.006)
        assert row["mark"] == "A"
