"""Test that exports without a named quality use final, and report its time per frame."""

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


def write_row_plate(path, red: np.ndarray, depth_m: np.ndarray):
    """Write a row of red light and its depths as a plate."""
    rows = {"R": red, "G": 0 * red, "B": 0 * red, "Z": depth_m}
    whole = {name: np.broadcast_to(row, (HEIGHT, WIDTH)) for name, row in rows.items()}
    return write_file(path, {n: np.ascontiguousarray(v, np.float32) for n, v in whole.items()})


@pytest.fixture
def card_plates(tmp_path):
    """Write two frames of a card behind the focus in front of a striped wall, and of the wall.

    Return the patterns of both sequences; the wall is the known background.
    """
    is_card = np.arange(WIDTH) < WIDTH // 2
    wall = np.where(np.arange(WIDTH) % 16 < 8, 0.1, 0.9)
    for frame in (1, 2):
        red, depth_m = np.where(is_card, 0.4, wall), np.where(is_card, FOCUS_M / 0.85, FAR_M)
        write_row_plate(tmp_path / f"card.{frame}.exr", red, depth_m)
        write_row_plate(tmp_path / f"wall.{frame}.exr", wall, np.full(WIDTH, FAR_M))
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


def test_blur_of_export_defaults_to_final_for_plates_only():
    """Other methods have no quality, and scenes gain nothing from final."""
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source="plate.####.exr")
    assert blur_of_export(shot) == DefocusSettings(quality=Quality.FINAL)
    blurs_of_qualities = [DefocusSettings(quality=quality) for quality in Quality]
    for blur in (
        *blurs_of_qualities,
        DefocusSettings(parts=7),
        DefocusSettings(method=Method.GATHER),
    ):
        assert blur_of_export(replace(shot, defocus=blur)) == blur
    for scene in ("demo", "scene.glb"):
        assert blur_of_export(replace(shot, source=scene)) == DefocusSettings()
    assert [blur.effective_quality for blur in (DefocusSettings(), *blurs_of_qualities)] == [
        Quality.FILM,
        *Quality,
    ]


def test_export_defaults_to_final_and_one_part_equals_film(card_plates, tmp_path, capsys):
    plate, wall = card_plates
    options = {
        "usual": (),
        "final": ("--quality", "final"),
        "film": ("--quality", "film"),
        "one": ("--parts", 1),
    }
    pictures = {
        name: exported(tmp_path / f"{name}.#.exr", plate, "--behind", wall, *words)
        for name, words in options.items()
    }
    assert np.array_equal(pictures["usual"], pictures["final"])
    assert np.array_equal(pictures["one"], pictures["film"])
    assert not np.array_equal(pictures["final"], pictures["film"])


def test_export_reports_time_per_frame_of_final_and_film(card_plates, tmp_path, capsys):
    plate, wall = card_plates
    exported(tmp_path / "known.#.exr", plate, "--behind", wall, "--progress", "json")
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    paces = [event["pace"] for event in events if event["event"] == "frame"]
    assert all("a frame; --quality film takes about" in pace for pace in paces)
    assert events[-1]["told"].endswith(f"{paces[-1]}.")
    exported(tmp_path / "flat.#.exr", wall)
    assert " s a frame.\n" in capsys.readouterr().err
    exported(tmp_path / "film.#.exr", plate, "--quality", "film")
    assert " a frame" not in capsys.readouterr().err


def test_export_with_processes_reports_time_once(card_plates, tmp_path, capsys):
    exported(tmp_path / "out.#.exr", card_plates[1], "--processes", "2")
    assert capsys.readouterr().err.count(" s a frame.") == 1


def test_pace_words_give_final_time_and_film_time_without_parts():
    assert pace_words(12.4, 9.3) == "about 12 s a frame; --quality film takes about 3.1 s"
    for parts_s in (0.0, 0.02):
        assert pace_words(0.25, parts_s) == "about 0.25 s a frame"


def test_export_keeps_quality_of_shot_file(tmp_path, capsys):
    shot_file = write_shot_file(tmp_path, defocus=DefocusSettings(quality=Quality.FILM))
    assert main(["export", str(shot_file), "-o", str(tmp_path / "n.#.exr"), "--frames=1001"]) == 0
    assert " a frame" not in capsys.readouterr().err
    blur_json = json.loads(shot_file.read_text())["defocus"]
    assert blur_json["quality"] == "film"
    del blur_json["quality"]
    default_shot = write_shot_file(tmp_path, defocus=DefocusSettings())
    assert json.loads(default_shot.read_text())["defocus"] == blur_json
