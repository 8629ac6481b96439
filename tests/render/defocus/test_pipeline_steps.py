"""The order of the blur's passes as the pipeline names them, and what it tells of its progress."""

from collections.abc import Iterator

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.render.defocus.line_solver import SweepSolver
from heatlens.render.defocus.pass_list import PASSES
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pipeline import DefocusPipeline
from heatlens.render.defocus.reduced_plate import PlateTextures
from heatlens.render.defocus.steps import ONLY
from heatlens.render.frame_renderer import drained
from heatlens.render.gpu.textures import download, new_texture, upload
from heatlens.render.source.pinhole import optics_of
from support.plates import lens_blurring, plate_of, room

SIZE = (48, 32)


class Rig:
    """A pipeline with a plate of the room in textures of its own."""

    def __init__(self, ctx) -> None:
        self.plate = plate_of(*room(*SIZE))
        self.pipeline = DefocusPipeline(ctx, DefocusPasses(ctx, SweepSolver(ctx)))
        self.color, self.depth = new_texture(ctx, SIZE, 4), new_texture(ctx, SIZE, 1)
        upload(self.color, self.plate.color)
        upload(self.depth, self.plate.depth_m)

    def steps(
        self, settings: DefocusSettings, lens: Lens | None = None, has_alpha: bool = False
    ) -> Iterator[str]:
        optics = optics_of(self.plate, self.plate.bins, lens or lens_blurring(6.0, 48))
        plate = PlateTextures(self.color, self.depth)
        return self.pipeline.steps(plate, optics, settings, has_alpha)

    def told(self, *steps: object, **options: bool) -> list[tuple[int, int]]:
        """Return the progress that is told: layers done, and their number."""
        told = []
        self.pipeline.on_layer = lambda done, layers: told.append((done, layers))
        list(self.steps(*steps, **options))
        self.pipeline.on_layer = None
        return told


def last_of_each(steps: list[str], name: str) -> list[int]:
    """Return where each run of the pass `name` ends."""
    later = [*steps[1:], ""]
    return [at for at, step in enumerate(steps) if step == name != later[at]]


@pytest.fixture(scope="module")
def rig(session_context):
    return Rig(session_context)


def test_each_step_is_a_declared_pass_and_layers_end_with_their_blur(rig):
    settings = DefocusSettings(Bokeh.DISC, Quality.DRAFT, 3)
    steps = list(rig.steps(settings))
    assert set(steps) <= {one.name for one in PASSES}
    assert steps[0] == "coc" and steps[-1] == "highlights drawn"
    assert steps.index("tiles") < steps.index("layer split")
    ends = last_of_each(steps, "blur")
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
def test_another_method_has_one_layer(rig, method, step):
    steps = list(rig.steps(DefocusSettings(method=method)))
    assert "layer split" not in steps and step in steps and steps[-1] == "limits"


@pytest.mark.parametrize("method", [Method.ACCUMULATION, Method.RAYTRACED])
def test_a_method_that_draws_a_scene_is_no_method_of_plates(rig, method):
    with pytest.raises(ValueError, match="cannot blur a plate"):
        list(rig.steps(DefocusSettings(method=method)))


def test_progress_is_told_from_the_first_layer_on(rig):
    settings = DefocusSettings(Bokeh.GAUSSIAN, Quality.DRAFT, 3)
    layers = len(last_of_each(list(rig.steps(settings)), "blur"))
    assert rig.told(settings) == [(done, layers) for done in range(layers)]
    lens = lens_blurring(6.0, 48)
    colored = Lens(
        lens.focal_length_mm, lens.f_stop, lens.focus_distance_m, 36.0, axial_colour_mm=0.5
    )
    told = rig.told(settings, colored)
    most = told[0][1]
    assert most % 3 == 0 and told == [(done, most) for done in range(most)]


def test_progress_with_alpha_is_that_of_two_pictures(rig):
    told = rig.told(DefocusSettings(Bokeh.GAUSSIAN, Quality.DRAFT, 3), has_alpha=True)
    most = told[0][1]
    assert most % 2 == 0 and told == [(done, most) for done in range(most)]


def test_a_turn_is_as_long_as_its_halves():
    for turn in (ONLY, *ONLY.halves, *ONLY.halves[1].halves):
        first, then = turn.halves
        assert first.before / first.pictures == turn.before / turn.pictures
        assert then.before - first.before == 1
        assert (then.before + 1) / then.pictures == (turn.before + 1) / turn.pictures


@pytest.mark.parametrize("proxy", [1.0, 0.5])
def test_a_lens_that_blurs_nothing_returns_the_plate_at_its_size(rig, proxy):
    settings = DefocusSettings(Bokeh.DISC, Quality.FILM, proxy=proxy)
    made = drained(rig.steps(settings, lens_blurring(1e-6, 48)))
    assert made.size == (48 * proxy, 32 * proxy)
    found, plate = download(made), rig.plate.color
    if proxy == 1.0:
        np.testing.assert_allclose(found, plate, rtol=1e-3, atol=1e-3)
    else:
        means = plate.reshape(16, 2, 24, 2, 4).mean(axis=(1, 3))
        assert np.abs(found - means).mean() < 0.02 * means.mean()


def test_a_picture_that_was_left_off_does_not_spoil_the_next(rig):
    settings = DefocusSettings(Bokeh.DISC, Quality.DRAFT, 3)
    whole = download(drained(rig.steps(settings)))
    for count in (1, 4, 9):
        steps = rig.steps(settings)
        for _ in range(count):
            next(steps)
        steps.close()
        np.testing.assert_array_equal(download(drained(rig.steps(settings))), whole)
