"""Test the conversion of camera log to light: middle gray, white, and gamut colors."""

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PictureCurve
from heatlens.fronts.commands.main import main
from heatlens.media.plate.header.entries import FOR_THE_EYE
from heatlens.media.plate.parts.picture_parts import color_parts, picture_header
from heatlens.media.plate.picture.display import decode_camera_log

# Signals of middle grey, from the makers' papers.
GREY = {
    PictureCurve.LOGC3: 0.391,
    PictureCurve.LOGC4: 0.2784,
    PictureCurve.SLOG3: 420 / 1023,
    PictureCurve.SLOG3_SGAMUT3: 420 / 1023,
    PictureCurve.APPLE_LOG: 0.4883,
    PictureCurve.VLOG: 0.4233,
    PictureCurve.CANON_LOG3: 0.3434,
    PictureCurve.LOG3G10: 1 / 3,
}
LOGS = [curve for curve in PictureCurve if curve.color_space is not None]


def test_gray_table_covers_every_log_curve():
    assert set(GREY) == set(LOGS)


@pytest.mark.parametrize("curve", LOGS)
def test_decode_camera_log_of_middle_gray_is_0_18_and_alpha_stays(tmp_path, curve):
    signal = np.full((2, 3, 4), GREY[curve], np.float32)
    signal[..., 3] = 0.4
    light = decode_camera_log(tmp_path, signal, curve.color_space)
    assert light[..., :3] == pytest.approx(0.18, rel=0.02) and (light[..., 3] == 0.4).all()


def test_decode_camera_log_of_logc3_matches_its_formula(tmp_path):
    """LogC3 at EI 800: light = (10^((signal - 0.385537) / 0.247190) - 0.052272) / 5.555556."""
    signal = np.linspace(0.15, 0.9, 50, dtype=np.float32)
    grey = np.repeat(signal[None, :, None], 3, axis=2)
    light = decode_camera_log(tmp_path, grey, PictureCurve.LOGC3.color_space)[0, :, 1]
    expected = (10 ** ((signal - 0.385537) / 0.247190) - 0.052272) / 5.555556
    assert light == pytest.approx(expected, rel=2e-3, abs=2e-4)


def test_decode_camera_log_of_wide_gamut_is_more_saturated(tmp_path):
    signal = np.array([[[0.5, 0.35, 0.35]]], np.float32)
    light = decode_camera_log(tmp_path, signal, PictureCurve.LOGC4.color_space)[0, 0]
    plain = light[0] / light[1]
    signals = np.array([0.5, 0.35])
    arri = (2 ** (14 * (signals - 95 / 1023) / (928 / 1023) + 6) - 64) / ((2**18 - 16) / 117.45)
    assert plain > 1.2 * arri[0] / arri[1]


def test_color_parts_of_log_image_is_scene_light_in_rec709(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(np.full((4, 4, 3), 100, np.uint8)).save(path)
    ((header, channels),) = color_parts(path, PictureCurve.SLOG3)
    assert FOR_THE_EYE not in header and "chromaticities" not in header
    assert FOR_THE_EYE not in picture_header(path, PictureCurve.SLOG3)
    assert FOR_THE_EYE in picture_header(path)
    assert channels["R"][0, 0] == pytest.approx(0.15, abs=0.04)
    Image.fromarray(np.full((4, 4), 100, np.uint8)).save(path)
    with pytest.raises(InputError, match="grey"):
        color_parts(path, PictureCurve.SLOG3)


def test_info_accepts_picture_curve_option(tmp_path, capsys):
    path = tmp_path / "a.png"
    Image.fromarray(np.full((4, 4, 3), 105, np.uint8)).save(path)
    assert main(["info", str(path), "--picture-curve", "slog3"]) == 0
    assert "colour range    0.18" in capsys.readouterr().out
