"""DefocusPipeline: the order of its pass names, and the progress that it reports."""

from collections.abc import Iterator

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.render.defocus.line_solver import SweepSolver
from heatlens.render.defocus.pass_list import PASSES
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pipeline import DefocusPipeline, LayerCallback
from heatlens.render.defocus.reduced_plate import PlateTextures
from heatlens.render.defocus.steps import ONLY
from heatlens.render.frame_renderer import run_all_steps
from heatlens.render.gpu.textures import download, new_texture, upload
from heatlens.render.source.pinhole import optics_of
from support.plates import lens_blurring, plate_of, room

SIZE = (48, 32)


class Rig:
    """A pipeline with a plate of the room in textures of its own."""

    def __init__(self, ctx) -> None:
        self.plate = plate_of(*room(*SIZE))
        self.pipeline = DefocusPipeline(
            ctx, passes=DefocusPasses(ctx, SweepSolver(ctx)), layer_callback=lambda: self.on_layer
        )
        self.on_layer: LayerCallback | None = None
        self.color, self.depth = new_texture(ctx, SIZE, 4), new_texture(ctx, SIZE, 1)
        upload(self.color, self.plate.color)
        upload(self.depth, self.plate.depth_m)

    def steps(
        self, settings: DefocusSettings, lens: Lens | None = None, has_alpha: bool = False
    ) -> Iterator[str]:
        optics = optics_of(self.plate, self.plate.bins, lens or lens_blurring(6.0, 48))
        plate = PlateTextures(self.color, self.depth)
        return self.pipeline.steps(plate, optics, settings, has_alpha)

    def collect_progress(self, *steps: object, **options: bool) -> list[tuple[int, int]]:
        """Run all steps and return the reported progress as (layers done, number of layers)."""
        reports = []
        self.on_layer = lambda done, layers: reports.append((done, layers))
        list(self.steps(*steps, **options))
        self.on_layer = None
        return reports


def last_steps_of_runs(steps: list[str], name: str) -> list[int]:
    """Return the index of the last step of each run of the pass `name`."""
    next_steps = [*steps[1:], ""]
    return [index for index, step in enumerate(steps) if step == name != next_steps[index]]


@pytest.fixture(scope="module")
def rig(session_context):
    return Rig(session_context)


def test_steps_are_declared_passes_and_layers_end_with_blur(rig):
    settings = DefocusSettings(bokeh=Bokeh.DISC, quality=Quality.DRAFT, layers=3)
    steps = list(rig.steps(settings))
    assert set(steps) <= {one.name for one in PASSES}
    assert steps[0] == "coc" and steps[-1] == "highlights drawn"
    assert steps.index("tiles") < steps.index("layer split")
    ends = last_steps_of_runs(steps, "blur")
    assert len(ends) > 1 == steps.count("tiles")
    for begin, end in zip([-1, *ends], ends, strict=False):
        part = steps[begin + 1 : end + 1]
        assert part.index("layer split") < part.index("coc fill") < part.index("blur")


@pytest.mark.parametrize(
    ("method", "step"),
    [
        (Method.HEAT, "blur"),
        (Method.GATHER, "gather"),
        (Method.SCATTER, "scatter"),
        (Method.PYRAMID, "pyramid"),
    ],
)
def test_steps_of_other_methods_have_no_layer_split(rig, method, step):
    steps = list(rig.steps(DefocusSettings(method=method)))
    assert "layer split" not in steps and step in steps and steps[-1] == "limits"


@pytest.mark.parametrize("method", [Method.ACCUMULATION, Method.RAYTRACED])
def test_steps_refuses_method_that_needs_a_scene(rig, method):
    with pytest.raises(ValueError, match="cannot blur a plate"):
        list(rig.steps(DefocusSettings(method=method)))


def test_progress_counts_layers_of_all_colors(rig):
    settings = DefocusSettings(bokeh=Bokeh.GAUSSIAN, quality=Quality.DRAFT, layers=3)
    layers = len(last_steps_of_runs(list(rig.steps(settings)), "blur"))
    assert rig.collect_progress(settings) == [(done, layers) for done in range(layers)]
    lens = lens_blurring(6.0, 48)
    colored = Lens(
        lens.focal_length_mm, lens.f_stop, lens.focus_distance_m, 36.0, axial_colour_mm=0.5
    )
    reports = rig.collect_progress(settings, colored)
    layers = reports[0][1]
    assert layers % 3 == 0 and reports == [(done, layers) for done in range(layers)]


def test_progress_with_alpha_counts_two_pictures(rig):
    settings = DefocusSettings(bokeh=Bokeh.GAUSSIAN, quality=Quality.DRAFT, layers=3)
    reports = rig.collect_progress(settings, has_alpha=True)
    layers = reports[0][1]
    assert layers % 2 == 0 and reports == [(done, layers) for done in range(layers)]


def test_turn_halves_split_its_progress_evenly():
    for turn in (ONLY, *ONLY.halves, *ONLY.halves[1].halves):
        first, then = turn.halves
        assert first.before / first.pictures == turn.before / turn.pictures
        assert then.before - first.before == 1
        assert (then.before + 1) / then.pictures == (turn.before + 1) / turn.pictures


@pytest.mark.parametrize("proxy", [1.0, 0.5])
def test_steps_without_blur_return_plate_at_proxy_size(rig, proxy):
    settings = DefocusSettings(Bokeh.DISC, Quality.FILM, proxy=proxy)
    texture = run_all_steps(rig.steps(settings, lens_blurring(1e-6, 48)))
    assert texture.size == (48 * proxy, 32 * proxy)
    pixels, plate = download(texture), rig.plate.color
    if proxy == 1.0:
        np.testing.assert_allclose(pixels, plate, rtol=1e-3, atol=1e-3)
    else:
        means = plate.reshape(16, 2, 24, 2, 4).mean(axis=(1, 3))
        assert np.abs(pixels - means).mean() < 0.02 * means.mean()


def test_steps_closed_early_do_not_change_next_picture(rig):
    settings = DefocusSettings(bokeh=Bokeh.DISC, quality=Quality.DRAFT, layers=3)
    whole = download(run_all_steps(rig.steps(settings)))
    for count in (1, 4, 9):
        steps = rig.steps(settings)
        for _ in range(count):
            next(steps)
        steps.close()
        np.testing.assert_array_equal(download(run_all_steps(rig.steps(settings))), whole)


def test_forgotten_plate_is_reduced_again(rig, session_context):
    """Textures keep their place when another plate is uploaded to them."""
    settings = DefocusSettings(Bokeh.DISC, Quality.FILM, proxy=0.5)
    fresh, other = Rig(session_context), rig.plate.color[::-1].copy()
    run_all_steps(rig.steps(settings))
    for each in (rig, fresh):
        upload(each.color, other)
    rig.pipeline.forget_plate()
    reduced, expected = (download(run_all_steps(it.steps(settings))) for it in (rig, fresh))
    upload(rig.color, rig.plate.color)
    rig.pipeline.forget_plate()
    np.testing.assert_array_equal(reduced, expected)
