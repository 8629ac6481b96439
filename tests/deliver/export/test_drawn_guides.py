"""Test the guides drawn into exported pictures, which have the same shapes as in the window."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.guides import (
    NO_GUIDES,
    Canvas,
    FrameLine,
    Guides,
    inner_rect,
    parse_desqueeze,
)
from heatlens.core.model.view.view import DisplayOptions
from heatlens.deliver.export.job import job_text
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.export.rendering import with_guides
from support.exports import HEIGHT, WIDTH, export_shot, refused_export_message, write_plates
from support.written_pictures import pixels


def grey(height: int = 90, width: int = 160) -> np.ndarray:
    return np.full((height, width, 3), 0.5, np.float32)


def test_with_guides_returns_same_picture_without_guides():
    picture = grey()
    assert with_guides(picture, NO_GUIDES, 2.0) is picture


@given(st.floats(0.2, 5.0), st.floats(0.5, 2.0), st.floats(0.1, 1.0))
def test_matte_darkens_pixels_outside_its_aspect_only(aspect, pixel_aspect, opacity):
    picture = with_guides(grey(), Guides(aspect, opacity), pixel_aspect)
    width, height = 160 * pixel_aspect, 90.0
    x0, y0, x1, y1 = inner_rect((0.0, 0.0, width, height), aspect)
    y, x = (np.mgrid[:90, :160] + 0.5) * np.array([1.0, pixel_aspect])[:, None, None]
    margin = 2 * max(1.0, pixel_aspect)  # the outline, and rounding
    inside = (x > x0 + margin) & (x < x1 - margin) & (y > y0 + margin) & (y < y1 - margin)
    outside = (x < x0 - margin) | (x > x1 + margin) | (y < y0 - margin) | (y > y1 + margin)
    np.testing.assert_array_equal(picture[inside], 0.5)
    np.testing.assert_allclose(picture[outside], 0.5 * (1 - opacity), atol=1e-6)


def test_thirds_and_center_cross_are_drawn_at_their_positions():
    lines = with_guides(grey(), Guides(thirds=True), 1.0) != 0.5
    np.testing.assert_allclose(np.flatnonzero(lines[3, :, 0]), [160 / 3, 320 / 3], atol=1)
    np.testing.assert_allclose(np.flatnonzero(lines[:, 3, 0]), [30, 60], atol=1)
    rows, columns, _ = np.nonzero(with_guides(grey(), Guides(centre=True), 1.0) != 0.5)
    assert (rows.mean(), columns.mean()) == (pytest.approx(45, abs=1), pytest.approx(80, abs=1))


def test_framing_lines_are_drawn_if_picture_has_their_aspect():
    line = FrameLine(name="239", frame=(0.25, 0.2, 0.75, 0.8), protection=(0.1, 0.1, 0.9, 0.9))
    guides = Guides(canvases=(Canvas(3200, 1800, (line,)),))
    drawn = with_guides(grey(), guides, 1.0)[..., 0] != 0.5
    np.testing.assert_allclose(np.flatnonzero(drawn[45]), [40, 120], atol=1)
    np.testing.assert_allclose(np.flatnonzero(drawn[:, 80]), [18, 72], atol=1)
    assert drawn[9, 16] and not drawn[9, 60:100].any()  # a corner of what is protected
    with pytest.raises(InputError, match="3200x1800"):
        with_guides(grey(width=90), guides, 1.0)


def test_export_job_file_draws_framing_lines(capsys, tmp_path):
    line = FrameLine("239", (0.25, 0.25, 0.75, 0.75))
    guides = Guides(canvases=(Canvas(float(WIDTH), float(HEIGHT), (line,)),))
    job, plates = tmp_path / "job.json", write_plates(tmp_path / "plates")
    lens = ("--f-stop", "2", "--focus-distance", "2", "--frames", "1001")
    export_shot(capsys, plates, tmp_path / "a" / "n.####.png", *lens)
    job.write_text(job_text(ExportOptions(), DisplayOptions(), guides))
    export_shot(capsys, plates, tmp_path / "b" / "n.####.png", *lens, "--job", job)
    plain, drawn = (pixels(tmp_path / folder / "n.1001.png") for folder in "ab")
    changed = (plain != drawn).any(axis=-1)
    assert changed[HEIGHT // 4, WIDTH // 2] and not changed[HEIGHT // 2, WIDTH // 2]


def test_desqueeze_widens_picture_to_square_pixels():
    ramp = np.broadcast_to(
        np.linspace(0.2, 0.8, 160, dtype=np.float32)[None, :, None], (90, 160, 3)
    )
    wide = with_guides(ramp, Guides(desqueeze=2.0), 1.0)
    assert wide.shape == (90, 320, 3)
    np.testing.assert_allclose(
        wide[:, 4:-4].reshape(90, 156, 2, 3).mean(2), ramp[:, 2:-2], atol=2e-3
    )
    thirds = with_guides(wide, Guides(thirds=True), 1.0)
    drawn = with_guides(ramp, Guides(thirds=True, desqueeze=2.0), 2.0)
    np.testing.assert_array_equal(drawn, thirds)  # the file's pixel aspect counts no more


def test_export_with_guide_options_draws_them_and_renders_anew(capsys, tmp_path):
    source, out = write_plates(tmp_path / "plates", (1001,)), tmp_path / "n.####.png"
    words = ("--quality", "draft", "--view", "sRGB curve")
    assert "1 frame written" in export_shot(capsys, source, out, *words)
    clean = pixels(tmp_path / "n.1001.png")
    drawn = (*words, "--matte", "2,39", "--thirds", "--desqueeze", "2")
    assert "1 frame written" in export_shot(capsys, source, out, *drawn)
    assert "0 frames written" in export_shot(capsys, source, out, *drawn)
    with_drawn_guides = pixels(tmp_path / "n.1001.png")
    assert clean.shape == (HEIGHT, WIDTH, 3) and with_drawn_guides.shape == (HEIGHT, 2 * WIDTH, 3)
    np.testing.assert_allclose(
        with_drawn_guides,
        255 * with_guides(np.float32(clean / 255), Guides(2.39, thirds=True, desqueeze=2), 1),
        atol=1.5,
    )


def test_export_rejects_impossible_guide_options(capsys, tmp_path):
    source = write_plates(tmp_path / "plates", (1001,))
    message = refused_export_message(capsys, source, tmp_path / "n.####.exr", "--thirds")
    assert "--thirds" in message and "EXR" in message
    message = refused_export_message(capsys, source, tmp_path / "n.####.png", "--matte", "wide")
    assert "'wide' is not an aspect" in message
    message = refused_export_message(
        capsys, source, tmp_path / "n.####.png", "--matte-opacity", "0.5"
    )
    assert "--matte" in message
    for text in ("0", "5", "x", "1:0"):
        with pytest.raises(InputError, match="desqueeze"):
            parse_desqueeze(text)
