"""Test `heatlens bench --drag`, which measures time and FLIP of each quality level of a drag."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench.drag import DragView, measure_drag, missing_flip_reason
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.preview.level_choice import cheaper_levels
from support.command_line import stderr_of_run
from support.session_files import room_file

SIZE = (64, 48)
WORDS = ("bench", "--drag", "--runs", "1")


@pytest.fixture
def frames(ctx) -> BenchFrames:
    return BenchFrames(ctx, "auto")


def report_of(capsys, *words: object) -> dict:
    assert main([*WORDS, "--json", *map(str, words)]) == 0
    captured = capsys.readouterr()
    assert all(line.startswith("heatlens: ") for line in captured.err.splitlines())
    return json.loads(captured.out)


def test_bench_drag_json_has_row_per_level(capsys):
    report = report_of(capsys, "--size", "64x48")
    drag = report["drag"]
    levels = cheaper_levels(DefocusSettings())
    assert report["frame"] is None
    assert len(drag["rows"]) == len(levels)
    assert [row["quality"] for row in drag["rows"]] == [str(it.effective_quality) for it in levels]
    assert [row["width"] for row in drag["rows"]] == sorted(
        (row["width"] for row in drag["rows"]), reverse=True
    )
    for row in drag["rows"]:
        assert row["pictures_per_s"] == pytest.approx(1e3 / row["ms"])
    assert drag["rows"][0]["flip"] is None
    assert all(0.0 <= row["flip"] <= 1.0 for row in drag["rows"][1:])


def test_bench_drag_text_table_is_aligned(capsys):
    assert main([*WORDS, "--size", "64x48", "--quality", "draft"]) == 0
    text = capsys.readouterr().out
    assert "drag: synthetic, 64x48" in text
    lines = [line for line in text.splitlines() if line.startswith(("at rest", *"1234567"))]
    assert len(lines) == len(cheaper_levels(DefocusSettings(quality=Quality.DRAFT)))
    assert len({len(line) for line in lines}) == 1


def test_bench_drag_uses_size_of_plate_or_smaller_one(capsys, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    full_report = report_of(capsys, "--plate", plate)["drag"]
    assert (full_report["width"], full_report["height"], full_report["source"]) == (
        96,
        64,
        str(plate),
    )
    half_report = report_of(capsys, "--plate", plate, "--size", "48x32", "--f-stop", "2")["drag"]
    assert (half_report["width"], half_report["height"]) == (48, 32)
    # one row for each level of the preview, the last at the smallest size
    assert half_report["rows"][0]["width"] == 48 and half_report["rows"][-1]["width"] < 48


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--f-stop", "2"), "--f-stop"),
        (("--depth-channel", "Z"), "--depth-channel"),
        (("--plate", "nowhere.exr"), "nowhere.exr is not there"),
    ],
)
def test_bench_drag_rejects_useless_options_and_missing_plate(capsys, words, message):
    assert message in stderr_of_run(capsys, 2, *WORDS, *words)


def test_bench_rejects_plate_without_drag_and_larger_size(capsys, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    assert "--drag" in stderr_of_run(capsys, 2, "bench", "--plate", plate)
    message = stderr_of_run(capsys, 2, *WORDS, "--plate", plate, "--size", "960x640")
    assert "room.exr" in message and "96x64" in message


def test_drag_view_at_rest_is_srgb_encoded_picture(frames):
    frame = frames.frame(scene_plate(SIZE), LENS, DefocusSettings(Bokeh.HEAT, layers=1))
    view = DragView(frame.renderer, SIZE)
    display = view.draw_at_rest(frame.render())
    expected = np.clip(encode_srgb(frame.renderer.pixels(frame.shot)[..., :3]), 0.0, 1.0)
    np.testing.assert_allclose(display, expected, atol=1.01 / 255)
    view.release()


@pytest.mark.parametrize("enlarges", [False, True])
def test_drag_view_moving_in_focus_is_close_to_rest(frames, enlarges):
    """A pinhole blurs nothing, so a smaller picture must still show the plate's detail."""
    lens = replace(LENS, f_stop=1e5)
    frame = frames.frame(scene_plate(SIZE), lens, DefocusSettings())
    view = DragView(frame.renderer, SIZE)
    rest_picture = view.draw_at_rest(frame.render())
    level = cheaper_levels(DefocusSettings())[-1]
    shot = Shot(lens, level)
    picture = run_all_steps(frame.renderer.steps(shot, enlarges=enlarges))
    moving_picture = view.draw_moving(picture, shot, 1.0)
    assert (picture.size == proxy_size(SIZE, level.proxy)) != enlarges
    assert float(np.abs(moving_picture - rest_picture).mean()) < 0.01
    view.release()


def test_finer_drag_levels_have_smaller_flip(frames):
    report = measure_drag(
        frames, scene_plate((320, 180)), LENS, DefocusSettings(), 1, lambda _: None
    )
    flips = [row.flip for row in report.rows[1:]]
    assert flips[0] == min(flips) and flips[0] < 0.03 < flips[-1]
    assert not math.isnan(sum(flips))


def test_bench_drag_without_flip_measures_times_with_message(frames, monkeypatch):
    def missing(*_args: object, **_options: object) -> None:
        raise InputError("FLIP needs pip install 'heatlens[compare]'")

    monkeypatch.setattr("heatlens.lab.measure.bench.drag.flip_evaluation", missing)
    messages: list[str] = []
    settings = DefocusSettings(quality=Quality.DRAFT)
    report = measure_drag(frames, scene_plate(SIZE), LENS, settings, 1, messages.append)
    assert (
        "heatlens[compare]" in messages[0]
        and messages[0] == missing_flip_reason() == report.flip_missing
    )
    assert all(row.flip is None and row.ms > 0.0 for row in report.rows)
