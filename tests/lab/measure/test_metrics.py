"""Test picture scores against closed forms on flat pictures, and rules that any distance obeys."""

import sys
from dataclasses import asdict, replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.lab.measure.metrics import PSNR_MOST_DB, flip_evaluation, nonfinite_count, score
from heatlens.media.plate.picture.display import encode_srgb

# Light whose sRGB value is one half: ((0.5 + 0.055) / 1.055) ^ 2.4.
HALF = 0.21404114


def flat_picture(value: float, shape: tuple[int, int] = (16, 24)) -> np.ndarray:
    return np.full((*shape, 3), value, np.float32)


@pytest.fixture
def noise(rng) -> np.ndarray:
    return rng.random((24, 32, 3), np.float32)


def test_score_of_equal_pictures_is_perfect(noise):
    scores = score(noise, noise)
    assert (scores.psnr_db, scores.relmse, scores.nonfinite) == (PSNR_MOST_DB, 0.0, 0)
    assert (scores.flip, scores.flip_hdr) == (0.0, 0.0)
    assert scores.ssim == pytest.approx(1.0, abs=1e-12)


# PSNR: the display values differ by d everywhere, -20 log10 d. SSIM of flat pictures a and b:
# (2ab + C) / (a^2 + b^2 + C) with C = 0.01^2. relMSE: (r - t)^2 / (t^2 + 0.01).
@pytest.mark.parametrize(
    ("result", "truth", "psnr_db", "ssim", "relmse"),
    [
        (0.0, 1.0, 0.0, 9.999e-5, 0.990099),
        (1.0, 0.0, 0.0, 9.999e-5, 100.0),
        (HALF, 1.0, 6.0206, 0.800016, 0.611615),
        (0.0, HALF, 6.0206, 3.99840e-4, 0.820832),
    ],
)
def test_score_of_flat_pictures_matches_closed_forms(result, truth, psnr_db, ssim, relmse):
    scores = score(flat_picture(result), flat_picture(truth))
    assert scores.psnr_db == pytest.approx(psnr_db, abs=1e-4)
    assert scores.ssim == pytest.approx(ssim, rel=1e-4)
    assert scores.relmse == pytest.approx(relmse, rel=1e-5)


def ssim_by_the_paper(a: np.ndarray, b: np.ndarray) -> float:
    """Compute equation 13 of Wang et al. 2004 in windows of 7 x 7 pixels, equally weighted."""
    height, width, channels = a.shape
    window_scores = []
    for y, x, c in np.ndindex(height - 6, width - 6, channels):
        p, q = (v[y : y + 7, x : x + 7, c].ravel().astype(np.float64) for v in (a, b))
        (var_p, cov), (_, var_q) = np.cov(p, q)
        luminance = (2 * p.mean() * q.mean() + 1e-4) / (p.mean() ** 2 + q.mean() ** 2 + 1e-4)
        window_scores.append(luminance * (2 * cov + 9e-4) / (var_p + var_q + 9e-4))
    return float(np.mean(window_scores))


def test_ssim_equals_formula_of_wang_et_al(noise, rng):
    light = noise[:17, :13]
    noisy_light = light + 0.2 * rng.random(light.shape, np.float32)
    expected = ssim_by_the_paper(encode_srgb(light), encode_srgb(noisy_light))
    assert score(light, noisy_light).ssim == pytest.approx(expected, abs=1e-9)


def test_only_hdr_scores_see_values_above_white():
    scores = score(flat_picture(8.0), flat_picture(4.0))
    assert (scores.psnr_db, scores.flip) == (PSNR_MOST_DB, 0.0)
    assert scores.flip_hdr > 0.1
    assert scores.relmse == pytest.approx(16 / 16.01, rel=1e-6)


def test_every_score_worsens_with_larger_error(noise, rng):
    error = rng.normal(0, 1, noise.shape).astype(np.float32)
    near, far = score(noise + 0.01 * error, noise), score(noise + 0.1 * error, noise)
    assert near.psnr_db > far.psnr_db
    assert near.ssim > far.ssim
    assert 0 < near.flip < far.flip <= 1
    assert 0 < near.flip_hdr < far.flip_hdr <= 1
    assert 0 < near.relmse < far.relmse


def test_display_scores_are_symmetric(noise):
    forward_scores, backward_scores = score(noise, noise**2), score(noise**2, noise)
    assert forward_scores.psnr_db == pytest.approx(backward_scores.psnr_db, rel=1e-9)
    assert forward_scores.ssim == pytest.approx(backward_scores.ssim, rel=1e-6)
    assert forward_scores.flip == pytest.approx(backward_scores.flip, rel=1e-3)


def test_nonfinite_pixels_are_counted_and_scored_as_black(noise):
    broken, black = noise.copy(), noise.copy()
    broken[3, 5] = (np.nan, 0.5, 0.5)
    broken[4, 5] = (np.inf, -np.inf, np.nan)
    black[3, 5] = (0, 0.5, 0.5)
    black[4, 5] = 0
    assert nonfinite_count(broken) == 2
    assert score(broken, noise) == replace(score(black, noise), nonfinite=2)


@pytest.mark.parametrize("darkness", [0.0, 1e-30, 1e-9])
def test_score_of_black_truth_is_finite(darkness):
    scores = score(flat_picture(1.0), flat_picture(darkness))
    assert all(np.isfinite(value) for value in asdict(scores).values())
    assert scores.flip_hdr > 0.5


def test_relmse_uses_negative_values(noise):
    scores = score(noise - 0.5, noise)
    assert scores.relmse == pytest.approx(
        np.mean(0.25 / (noise.astype(float) ** 2 + 0.01)), rel=1e-5
    )


def test_score_rejects_different_sizes_and_names_both(noise):
    with pytest.raises(InputError, match=r"32 x 24 pixels.*30 x 24"):
        score(noise, noise[:, :30])


def test_score_rejects_too_small_pictures():
    with pytest.raises(InputError, match="these have 24 x 6"):
        score(flat_picture(0, (6, 24)), flat_picture(0, (6, 24)))


@pytest.mark.parametrize("module", ["flip_evaluator"])
def test_score_without_flip_names_pip_install(monkeypatch, module, noise):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=r"pip install 'heatlens\[compare\]'") as refusal:
        score(noise, noise)
    assert module.partition(".")[0] in str(refusal.value)


def test_flip_evaluation_returns_error_per_pixel(noise):
    error, mean, _ = flip_evaluation(noise, noise[::-1].copy(), "LDR")
    assert error.shape == (24, 32, 1)
    assert error.mean() == pytest.approx(mean, rel=1e-5)
