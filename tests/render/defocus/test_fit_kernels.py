"""The fit of the disc kernels: its slopes, its exact constraints, and the stored kernels."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.special import jv

import heatlens
from heatlens.core.model.lens.opening import profile
from heatlens.render.defocus.fit_kernels import (
    COS_LEAST,
    POWERS,
    Fit,
    _RankSearch,
    fit_disc,
    fit_of_rank,
    fit_rims,
    images_of,
    main,
    refine_poles,
)
from heatlens.render.defocus.kernel_error import DiscError, spectrum
from heatlens.render.defocus.kernels import RIMS, named_kernel, rim_kernel

NAMES = list(POWERS)
PACKAGE = Path(heatlens.__file__).parent


@pytest.fixture(scope="module")
def error() -> DiscError:
    return DiscError()


def stored_fit(name: str) -> Fit:
    kernel = named_kernel(name)
    return Fit(
        kernel.poles, kernel.mix, DiscError(POWERS[name]).evaluate(kernel.poles, kernel.mix)[0]
    )


def check_exact(fit: Fit) -> None:
    """Check light, variance, symmetry and stability, which every fit must keep."""
    assert fit.mix.sum().real == pytest.approx(1.0, abs=1e-9)
    assert 2 * (fit.mix.sum(axis=1) @ fit.poles).real == pytest.approx(1 / 16, rel=1e-9)
    np.testing.assert_allclose(fit.mix, fit.mix.T, atol=1e-12)
    assert np.cos(np.angle(fit.poles) / 2).min() >= COS_LEAST - 1e-9


def test_disc_norm_without_weight_is_norm_of_disc_picture(error):
    """Parseval: without its weight the norm of a disc of radius 1 and light 1 is 1 / pi.

    Over an eighth of the plane, in radians, that is (2 pi)^2 / 8 times as much; frequencies beyond
    the greatest one hold what is missing.
    """
    plain = DiscError(power=0.0)
    assert 0.97 * np.pi / 2 < plain.disc_norm < np.pi / 2


def test_disc_error_slopes_match_finite_differences(error, rng):
    fit, step = stored_fit("disc_3"), 1e-6
    _, by_pole, by_mix = error.evaluate(fit.poles, fit.mix)
    change = rng.normal(size=3) + 1j * rng.normal(size=3)
    ahead, behind = (
        error.evaluate(fit.poles + s * 1e-3 * change, fit.mix)[0] for s in (step, -step)
    )
    assert (ahead - behind) / (2 * step) == pytest.approx((by_pole @ change * 1e-3).real, rel=1e-4)
    change = rng.normal(size=(3, 3)) + 1j * rng.normal(size=(3, 3))
    change = change + change.T
    ahead, behind = (error.evaluate(fit.poles, fit.mix + s * change)[0] for s in (step, -step))
    expected = np.sum(by_mix * change).real
    assert (ahead - behind) / (2 * step) == pytest.approx(expected, rel=1e-4)


def test_rank_search_slopes_match_finite_differences(error, rng):
    fit, search = stored_fit("disc_3"), _RankSearch(error, count=3, rank=2)
    images, logs = images_of(fit.mix)[:, :2], np.log(fit.poles)
    point = np.concatenate([logs.real, logs.imag, images.real.ravel(), images.imag.ravel()])
    change, step = rng.normal(size=point.size), 1e-6
    for of, slopes in (
        (lambda p: search.error_of(p)[0], search.error_of(point)[1]),
        (search.excess, search.excess_slopes(point)),
    ):
        found = (of(point + step * change) - of(point - step * change)) / (2 * step)
        np.testing.assert_allclose(found, slopes @ change, rtol=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_best_mix_beats_other_mixes_of_same_poles(name, rng):
    error, poles = DiscError(POWERS[name]), named_kernel(name).poles
    mix, _ = error.best_mix(poles)
    fit = Fit(poles, mix, error.evaluate(poles, mix)[0])
    check_exact(fit)
    for _ in range(5):
        off = rng.normal(size=mix.shape) + 1j * rng.normal(size=mix.shape)
        other = mix + 1e-3 * (off + off.T)
        poles_2 = np.stack([np.ones_like(poles), 2 * poles])
        # Back to the exact light and variance, by the smallest change of the diagonal.
        miss = np.array([other.sum().real - 1, 2 * (other.sum(axis=1) @ poles).real - 1 / 16])
        rows = np.concatenate([poles_2.real, -poles_2.imag], axis=1)
        back = np.linalg.lstsq(rows, miss, rcond=None)[0]
        other = other - np.diag(back[: len(poles)] + 1j * back[len(poles) :])
        assert error.evaluate(poles, other)[0] > fit.error


def test_fit_disc_finds_stored_two_poles_again(error):
    """The fit equals the stored kernel up to sampling, the order of the poles and conjugation."""
    fit, before = fit_disc(2, starts=4), stored_fit("disc_2")
    check_exact(fit)
    order = np.argsort(-np.abs(fit.poles))
    poles, mix = fit.poles[order], fit.mix[np.ix_(order, order)]
    if poles[0].imag > 0:
        poles, mix = poles.conj(), mix.conj()
    np.testing.assert_allclose(poles, before.poles, rtol=0.02)
    np.testing.assert_allclose(mix, before.mix, atol=0.03)
    assert 0.9995 * before.error < fit.error <= before.error


@pytest.mark.parametrize("name", NAMES)
def test_refine_poles_from_stored_poles_reaches_stored_error(name):
    error, before = DiscError(POWERS[name]), stored_fit(name)
    fit = refine_poles(error, before.poles)
    check_exact(fit)
    assert fit.error <= before.error


@pytest.mark.parametrize("name", NAMES)
def test_images_of_mix_multiply_to_the_mix(name):
    images = images_of(named_kernel(name).mix)
    np.testing.assert_allclose(images @ images.T, named_kernel(name).mix, atol=1e-9)
    shares = np.linalg.norm(images, axis=0)
    assert np.all(np.diff(shares) <= 0)


def test_fit_of_rank_beats_truncated_images(error):
    before = stored_fit("disc_3")
    fit = fit_of_rank(error, before, 2)
    check_exact(fit)
    assert np.linalg.matrix_rank(fit.mix, tol=1e-9) == 2
    cut = images_of(before.mix)[:, :2]
    assert fit.error < error.evaluate(before.poles, cut @ cut.T)[0]


def test_fit_kernels_command_writes_kernels_in_stored_format(tmp_path, capsys):
    path = tmp_path / "kernels.json"
    assert main(["disc_2", "--from-stored", "-o", str(path)]) == 0
    entry = json.loads(path.read_text())["kernels"]["disc_2"]
    poles = np.array(entry["kappa"]) @ [1, 1j]
    np.testing.assert_allclose(poles, named_kernel("disc_2").poles, rtol=0.02)
    assert np.array(entry["M"]).shape == (2, 2, 2) and entry["variance_over_disc"] == 1.0
    assert "disc_2: 2 poles, 2 images, error 9.36" in capsys.readouterr().out


@pytest.mark.parametrize("rim", [-1.0, -0.3, 0.0, 0.8])
def test_spectrum_is_hankel_transform_of_profile(rim):
    """The Hankel transform of the brightness, by the midpoint rule."""
    place = (np.arange(4000) + 0.5) / 4000
    for q in (0.3, 3.0, 17.0):
        expected = np.mean(2 * place * profile(place**2, rim) * jv(0, q * place))
        assert spectrum(np.array(q), rim) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", ["disc_2", "disc_3", "disc_4"])
@pytest.mark.parametrize("rim", [-0.9, -0.5, 0.4, 1.0])
def test_rim_kernel_fits_its_rim_better_than_flat_disc_kernel(name, rim):
    """Rims between the stored ones mix two kernels. Kernels of two poles reduce the error less."""
    error, flat, kernel = DiscError(POWERS[name], rim), named_kernel(name), rim_kernel(name, rim)
    left = error.evaluate(kernel.poles, kernel.mix)[0] / error.evaluate(flat.poles, flat.mix)[0]
    assert left < (0.6 if name == "disc_2" else 0.2)


def test_fit_rims_reaches_errors_of_stored_rim_kernels():
    found = fit_rims("disc_2")
    for rim, fit in zip(RIMS, found, strict=True):
        check_exact(fit)
        error, kernel = DiscError(POWERS["disc_2"], rim), rim_kernel("disc_2", rim)
        if rim != 0.0:
            assert error.evaluate(kernel.poles, kernel.mix)[0] == pytest.approx(fit.error, rel=0.02)


def test_fit_kernels_command_writes_rim_kernels_in_stored_format(tmp_path, capsys):
    path = tmp_path / "rims.json"
    assert main(["disc_2", "--rims", "-o", str(path)]) == 0
    entries = json.loads(path.read_text())["kernels"]
    assert [entry["rim"] for entry in entries] == list(RIMS)
    stored_lines = (PACKAGE / "render/defocus" / "rim_kernels.json").read_text()
    assert set(entries[0]) == set(json.loads(stored_lines)["kernels"][0])
    assert "disc_2 rim 1: error" in capsys.readouterr().out


def test_only_kernel_fit_modules_import_scipy():
    texts = {path.name: path.read_text("utf-8") for path in PACKAGE.rglob("*.py")}
    users = [name for name, text in texts.items() if "defocus.fit_kernels import" in text]
    users += [name for name, text in texts.items() if "defocus.kernel_error import" in text]
    scipy = sorted(
        name for name, text in texts.items() if "import scipy" in text or "from scipy" in text
    )
    assert users == ["fit_kernels.py"] and scipy == ["fit_kernels.py", "kernel_error.py"]
