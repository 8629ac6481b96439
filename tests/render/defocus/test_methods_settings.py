"""The defocus method as chosen by settings, `heatlens render` and `heatlens export`."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from heatlens.render.defocus.kernels import named_kernel
from heatlens.render.defocus.quality import kernel_for
from support.command_line import CAMERA, channels, picture
from support.command_line import render as render_file
from support.exr_files import write_file
from support.methods_of_plates import OF_PLATES, OTHERS
from support.plates import lens_blurring, plate_of, room


def test_heat_method_equals_diffusion_with_one_heat_layer(ctx, renderer):
    plate, lens = plate_of(*room()), lens_blurring(12.0, 96)
    renderer.load(plate)
    basic = renderer.pixels(Shot(lens, DefocusSettings(Bokeh.HEAT, layers=1)))
    for settings in (DefocusSettings(method=Method.HEAT), DefocusSettings(Bokeh.DISC, layers=5)):
        heat = renderer.pixels(Shot(lens, replace(settings, method=Method.HEAT)))
        assert np.array_equal(heat, basic)
    assert kernel_for(DefocusSettings(method=Method.HEAT)) == named_kernel("heat")


def test_other_methods_ignore_bokeh_quality_and_layers(ctx, renderer):
    renderer.load(plate_of(*room()))
    lens = lens_blurring(12.0, 96)
    for method in OTHERS:
        plain = renderer.pixels(Shot(lens, DefocusSettings(method=method)))
        other = DefocusSettings(Bokeh.GAUSSIAN, Quality.DRAFT, 3, 1.0, method)
        assert np.array_equal(renderer.pixels(Shot(lens, other)), plain)


@pytest.mark.parametrize("method", OF_PLATES)
def test_render_command_blurs_with_every_method(capsys, tmp_path, method):
    plate, out = tmp_path / "plate.exr", tmp_path / "out.exr"
    write_file(plate, channels(), **CAMERA)
    render_file(capsys, plate, out, "--method", method, "--f-stop", 0.2)
    _, pixels = picture(out)
    color = np.stack([channels()[name] for name in "RGB"], axis=2)
    assert np.isfinite(pixels).all() and np.abs(pixels[..., :3] - color).max() > 0.01


def test_export_uses_method_of_shot_or_of_option(capsys, tmp_path):
    plate = write_file(tmp_path / "plate.exr", channels(), **CAMERA)
    shot_file = tmp_path / "s.heatlens.json"
    lens = Lens(50.0, 0.2, 2.24, 36.0)
    write_shot(shot_file, Shot(lens, DefocusSettings(method=Method.SCATTER), source=str(plate)))
    for words, method in (((), Method.SCATTER), (("--method", "gather"), Method.GATHER)):
        exported, rendered = tmp_path / f"{method}.exr", tmp_path / f"r_{method}.exr"
        assert main(["export", str(shot_file), "-o", str(exported), *words]) == 0
        capsys.readouterr()
        render_file(capsys, plate, rendered, "--method", method, "--f-stop", 0.2)
        assert np.array_equal(picture(exported)[1], picture(rendered)[1])
    assert not np.array_equal(picture(exported)[1], picture(tmp_path / "scatter.exr")[1])
