"""Exports are final where nobody names a quality, and tell what that costs."""

import json
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.job import blur_of_export
from heatlens.deliver.export.rendering import pace_words
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_read import read_parts
from support.exports import write_shot_file
from support.exr_files import write_file
from support.plates import FAR_M, FOCUS_M, lens_blurring

HEIGHT, WIDTH, COC_PX = 24, 96, 20.0
LENS = lens_blurring(COC_PX, WIDTH)


def write_part(path, red: np.ndarray, depth_m: np.ndarray):
    """Write a row of red light and its depths as a plate."""
    rows = {"R": red, "G": 0 * red, "B": 0 * red, "Z": depth_m}
    whole = {name: np.broadcast_to(row, (HEIGHT, WIDTH)) for name, row in rows.items()}
    return write_file(path, {n: np.ascontiguousarray(v, np.float32) for n, v in whole.items()})


@pytest.fixture
def card(tmp_path):
    """Write two frames of a card little behind the focus, before a striped wall known behind."""
    is_card = np.arange(WIDTH) < WIDTH // 2
    wall = np.where(np.arange(WIDTH) % 16 < 8, 0.1, 0.9)
    for frame in (1, 2):
        red, depth_m = np.where(is_card, 0.4, wall), np.where(is_card, FOCUS_M / 0.85, FAR_M)
        write_part(tmp_path / f"card.{frame}.exr", red, depth_m)
        write_part(tmp_path / f"wall.{frame}.exr", wall, np.full(WIDTH, FAR_M))
    return tmp_path / "card.#.exr", tmp_path / "wall.#.exr"


def exported(out, plate, *words: object) -> np.ndarray:
    lens = {
        "--f-stop": LENS.f_stop,
        "--focal-length": LENS.focal_length_mm,
        "--sensor-width": LENS.sensor_width_mm,
        "--focus-distance": FOCUS_M,
    }
    options = [f"{name}={value}" for name, value in lens.items()]
    assert main(["export", str(plate), "-o", str(out), *options, *map(str, words)]) == 0
    ((_, channels),) = read_parts(out.with_name(out.name.replace("#", "2")))
    return channels["R"]


def test_plates_are_final_where_neither_a_quality_nor_parts_are_named():
    """Other methods have no quality, and scenes gain nothing."""
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source="plate.####.exr")
    assert blur_of_export(shot) == DefocusSettings(quality=Quality.FINAL)
    named = [DefocusSettings(quality=quality) for quality in Quality]
    for told in (*named, DefocusSettings(parts=7), DefocusSettings(method=Method.GATHER)):
        assert blur_of_export(replace(shot, defocus=told)) == told
    for scene in ("demo", "scene.glb"):
        assert blur_of_export(replace(shot, source=scene)) == DefocusSettings()
    assert [told.at_quality for told in (DefocusSettings(), *named)] == [Quality.FILM, *Quality]


def test_an_export_that_names_nothing_is_final_and_one_part_is_film(card, tmp_path, capsys):
    plate, wall = card
    options = {
        "usual": (),
        "final": ("--quality", "final"),
        "film": ("--quality", "film"),
        "one": ("--parts", 1),
    }
    made = {
        name: exported(tmp_path / f"{name}.#.exr", plate, "--behind", wall, *words)
        for name, words in options.items()
    }
    assert np.array_equal(made["usual"], made["final"])
    assert np.array_equal(made["one"], made["film"])
    assert not np.array_equal(made["final"], made["film"])


def test_the_time_of_final_and_of_film_is_told(card, tmp_path, capsys):
    plate, wall = card
    exported(tmp_path / "known.#.exr", plate, "--behind", wall, "--progress", "json")
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    paces = [event["pace"] for event in events if event["event"] == "frame"]
    assert all("a frame, film about" in pace for pace in paces)
    assert events[-1]["told"].endswith(f"{paces[-1]}.")
    exported(tmp_path / "flat.#.exr", wall)
    assert "a frame, here the same as film.\n" in capsys.readouterr().err
    exported(tmp_path / "film.#.exr", plate, "--quality", "film")
    assert "final" not in capsys.readouterr().err


def test_the_time_is_told_once_for_several_processes(card, tmp_path, capsys):
    exported(tmp_path / "out.#.exr", card[1], "--processes", "2")
    assert capsys.readouterr().err.count("quality final") == 1


def test_film_takes_what_the_parts_leave():
    assert pace_words(12.4, 9.3) == "quality final: about 12 s a frame, film about 3.1 s"
    for parts_s in (0.0, 0.02):
        told = pace_words(0.25, parts_s)
        assert told == "quality final: about 0.25 s a frame, here the same as film"


def test_a_quality_of_the_shot_is_kept(tmp_path, capsys):
    shot_file = write_shot_file(tmp_path, defocus=DefocusSettings(quality=Quality.FILM))
    assert main(["export", str(shot_file), "-o", str(tmp_path / "n.#.exr"), "--frames=1001"]) == 0
    assert "final" not in capsys.readouterr().err
    told = json.loads(shot_file.read_text())["defocus"]
    assert told["quality"] == "film"
    del told["quality"]
    unnamed = write_shot_file(tmp_path, defocus=DefocusSettings())
    assert json.loads(unnamed.read_text())["defocus"] == told
