"""Test ASC framing decision lists: where their lines lie in an image of each shape."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.guides import Canvas, FrameLine, frame_lines_for
from heatlens.media.documents.frame_line_file import read_canvases
from heatlens.media.files import limits


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch):
    """Read in this process, where faults are seen; only the test of damaged files does not."""
    monkeypatch.setattr("heatlens.media.documents.frame_line_file.is_bounded", lambda: True)
    monkeypatch.setattr("heatlens.media.documents.frame_line_file.allow_for", lambda path: None)


def size(width: float, height: float) -> dict[str, float]:
    return {"width": width, "height": height}


def point(x: float, y: float) -> dict[str, float]:
    return {"x": x, "y": y}


def decision(name: str, x: float, y: float, width: float, height: float, **fields) -> dict:
    entry = {"id": f"canvas-{name}", "label": name, "framing_intent_id": name}
    return entry | {"dimensions": size(width, height), "anchor_point": point(x, y)} | fields


def write_frame_line_list(path, *decisions, squeeze=1.0, width=4000, height=2000, **fields):
    """Write a list with a canvas, as the schema of the ASC wants it."""
    intents = [
        {"id": it["label"], "label": it["label"], "aspect_ratio": size(239, 100), "protection": 0.1}
        for it in decisions
    ]
    canvas = {"id": "canvas", "label": "Open gate", "source_canvas_id": "canvas"}
    canvas |= {"dimensions": size(width, height), "anamorphic_squeeze": squeeze}
    canvas |= {"framing_decisions": list(decisions)} | fields
    top = {
        "uuid": "5463dbe4-ec30-4324-b8a1-67408aed40db",
        "version": {"major": 2, "minor": 0},
        "fdl_creator": "a camera",
        "framing_intents": intents,
        "contexts": [{"label": "A", "context_creator": "a camera", "canvases": [canvas]}],
    }
    path.write_text(json.dumps(top))
    return path


KEPT = {"protection_dimensions": size(3800, 1800), "protection_anchor_point": point(100, 100)}


def test_read_canvases_gives_frame_and_protection_as_fractions(tmp_path):
    path = write_frame_line_list(tmp_path / "a.fdl", decision("239", 400, 500, 2000, 1000, **KEPT))
    (canvas,) = read_canvases(path)
    (line,) = canvas.lines
    assert (canvas.width, canvas.height, line.name) == (4000, 2000, "239")
    assert line.frame == pytest.approx((0.1, 0.25, 0.6, 0.75))
    assert line.protection == pytest.approx((0.025, 0.05, 0.975, 0.95))


def test_lines_of_image_of_effective_area_are_relative_to_it(tmp_path):
    """The anchor point of a frame is relative to the whole canvas."""
    path = write_frame_line_list(
        tmp_path / "a.fdl",
        decision("239", 400, 500, 2000, 1000),
        effective_dimensions=size(3000, 1600),
        effective_anchor_point=point(100, 300),
    )
    canvases = read_canvases(path)
    (line,) = frame_lines_for(canvases, 3000, 1600)
    assert line.frame == pytest.approx((0.1, 0.125, 0.1 + 2 / 3, 0.75)) and line.protection is None
    (canvas_line,) = frame_lines_for(canvases, 4000, 2000)
    assert canvas_line.frame == pytest.approx((0.1, 0.25, 0.6, 0.75))


def test_lines_of_squeezed_canvas_fit_desqueezed_image_too(tmp_path):
    path = write_frame_line_list(
        tmp_path / "a.fdl", decision("239", 400, 500, 2000, 1000), squeeze=1.5
    )
    canvases = read_canvases(path)
    assert frame_lines_for(canvases, 6000, 2000) == frame_lines_for(canvases, 4000, 2000) != ()
    assert frame_lines_for(canvases, 1920, 640) != () == frame_lines_for(canvases, 1920, 1080)


def test_lines_of_prefers_canvas_of_same_size_over_same_shape():
    small = Canvas(200, 100, (FrameLine("small", (0, 0, 1, 1)),))
    large = Canvas(400, 200, (FrameLine("large", (0, 0, 1, 1)),))
    assert frame_lines_for((small, large), 400, 200)[0].name == "large"
    assert frame_lines_for((small, large), 800, 400)[0].name == "small"


PARTS = st.floats(0.0, 1.0)


@given(PARTS, PARTS, st.floats(0.01, 1.0), st.floats(0.01, 1.0))
def test_read_canvases_places_any_frame_at_its_pixels(tmp_path_factory, x, y, across, down):
    rect = x * (1 - across) * 4000, y * (1 - down) * 2000, across * 4000, down * 2000
    path = write_frame_line_list(tmp_path_factory.mktemp("fdl") / "a.fdl", decision("x", *rect))
    ((line,),) = (it.lines for it in read_canvases(path))
    x0, y0, x1, y1 = line.frame
    rect_of_line = x0 * 4000, y0 * 2000, (x1 - x0) * 4000, (y1 - y0) * 2000
    assert rect_of_line == pytest.approx(rect, abs=1e-6)


DAMAGED = ("", "x", "{}", "[1]", '{"uuid": 3}', "\0", "\udcff")


@pytest.mark.parametrize("text", DAMAGED)
def test_read_canvases_rejects_damaged_file_by_name(tmp_path, text, monkeypatch):
    monkeypatch.setattr("heatlens.media.documents.frame_line_file.is_bounded", limits.is_bounded)
    path = tmp_path / "a.fdl"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=r"a\.fdl"):
        read_canvases(path)


def test_read_canvases_rejects_list_without_decision_and_missing_file(tmp_path):
    with pytest.raises(InputError, match="no framing decision"):
        read_canvases(write_frame_line_list(tmp_path / "a.fdl"))
    with pytest.raises(InputError, match=r"gone\.fdl"):
        read_canvases(tmp_path / "gone.fdl")
