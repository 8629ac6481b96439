"""`heatlens bench --drag`: every level of the window's ladder, its time and its FLIP."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench.drag import DragView, flip_missing, measure_drag
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.media.plate.picture.display import srgb_encoded
from heatlens.render.preview.level_choice import cheaper
from support.command_line import stderr_of_run
from support.session_files import room_file

SIZE = (64, 48)
WORDS = ("bench", "--drag", "--runs", "1")


@pytest.fixture
def frames(ctx) -> BenchFrames:
    return BenchFrames(ctx, "auto")


def report_of(capsys, *words: object) -> dict:
    assert main([*WORDS, "--json", *map(str, words)]) == 0
    said = capsys.readouterr()
    assert all(line.startswith("heatlens: ") for line in said.err.splitlines())
    return json.loads(said.out)


def test_there_is_a_row_for_each_level_and_no_table_of_passes(capsys):
    report = report_of(capsys, "--size", "64x48")
    drag = report["drag"]
    levels = cheaper(DefocusSettings())
    assert report["frame"] is None
    assert len(drag["rows"]) == len(levels)
    assert [row["quality"] for row in drag["rows"]] == [str(it.at_quality) for it in levels]
    assert [row["width"] for row in drag["rows"]] == sorted(
        (row["width"] for row in drag["rows"]), reverse=True
    )
    for row in drag["rows"]:
        assert row["pictures_per_s"] == pytest.approx(1e3 / row["ms"])
    assert drag["rows"][0]["flip"] is None
    assert all(0.0 <= row["flip"] <= 1.0 for row in drag["rows"][1:])


def test_the_table_is_for_reading(capsys):
    assert main([*WORDS, "--size", "64x48", "--quality", "draft"]) == 0
    text = capsys.readouterr().out
    assert "drag: synthetic, 64x48" in text
    lines = [line for line in text.splitlines() if line.startswith(("at rest", *"1234567"))]
    assert len(lines) == len(cheaper(DefocusSettings(quality=Quality.DRAFT)))
    assert len({len(line) for line in lines}) == 1


def test_a_plate_is_dragged_as_large_as_it_is_or_smaller(capsys, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    whole = report_of(capsys, "--plate", plate)["drag"]
    assert (whole["width"], whole["height"], whole["source"]) == (96, 64, str(plate))
    half = report_of(capsys, "--plate", plate, "--size", "48x32", "--f-stop", "2")["drag"]
    assert (half["width"], half["height"]) == (48, 32)
    assert half["rows"][0]["width"] == 48 and half["rows"][-1]["width"] < 48


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--f-stop", "2"), "--f-stop"),
        (("--depth-channel", "Z"), "--depth-channel"),
        (("--plate", "nowhere.exr"), "nowhere.exr is not there"),
    ],
)
def test_what_would_change_nothing_or_is_not_there_is_refused(capsys, words, said):
    assert said in stderr_of_run(capsys, 2, *WORDS, *words)


def test_a_plate_without_drag_or_larger_than_it_is_is_refused(capsys, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    assert "--drag" in stderr_of_run(capsys, 2, "bench", "--plate", plate)
    said = stderr_of_run(capsys, 2, *WORDS, "--plate", plate, "--size", "960x640")
    assert "room.exr" in said and "96x64" in said


def test_at_rest_it_is_the_picture_in_the_plain_curve(frames):
    frame = frames.frame(scene_plate(SIZE), LENS, DefocusSettings(Bokeh.HEAT, layers=1))
    view = DragView(frame.renderer, SIZE)
    shown = view.at_rest(frame.render())
    expected = np.clip(srgb_encoded(frame.renderer.pixels(frame.shot)[..., :3]), 0.0, 1.0)
    np.testing.assert_allclose(shown, expected, atol=1.01 / 255)
    view.release()


def test_where_all_is_in_focus_a_level_shows_the_plate_itself(frames):
    """Nothing is blurred through a pinhole: what a small picture lacks is the plate's detail."""
    lens = replace(LENS, f_stop=1e5)
    frame = frames.frame(scene_plate(SIZE), lens, DefocusSettings())
    view = DragView(frame.renderer, SIZE)
    rest = view.at_rest(frame.render())
    level = cheaper(DefocusSettings())[2]
    shot = Shot(lens, level)
    moving = view.moving(frame.renderer.render(shot), shot, 1.0)
    assert level.proxy < 1.0
    assert float(np.abs(moving - rest).mean()) < 0.01
    view.release()


def test_finer_levels_come_nearer_to_the_rest(frames):
    report = measure_drag(
        frames, scene_plate((320, 180)), LENS, DefocusSettings(), 1, lambda _: None
    )
    flips = [row.flip for row in report.rows[1:]]
    assert flips[0] == min(flips) and flips[0] < 0.03 < flips[-1]
    assert not math.isnan(sum(flips))


def test_without_the_package_times_are_measured_and_it_is_said(frames, monkeypatch):
    def missing(*_args: object, **_options: object) -> None:
        raise InputError("FLIP needs pip install 'heatlens[compare]'")

    monkeypatch.setattr("heatlens.lab.measure.bench.drag.flip_evaluation", missing)
    said: list[str] = []
    settings = DefocusSettings(quality=Quality.DRAFT)
    report = measure_drag(frames, scene_plate(SIZE), LENS, settings, 1, said.append)
    assert "heatlens[compare]" in said[0] and said[0] == flip_missing() == report.flip_missing
    assert all(row.flip is None and row.ms > 0.0 for row in report.rows)
