"""Test impossible depth, circles of confusion and light: they are corrected on reading."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.depth.repair import COC_MOST_PX, DEPTH_LEAST_M, LIGHT_MOST
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, write_file

HEIGHT, WIDTH = 20, 28
LENSES = (Lens(50.0, 2.0, 2.0, 36.0), Lens(1000.0, 0.7, 1500.0, 36.0), Lens(8.0, 22.0, 1e9, 36.0))
# Not smaller: what processors may take for 0 would be a mark of the sky.
TINY = (1e-37, 1e-30, 1e-12, 1e-9, 1e-7)


def plate_of(tmp_path, depth, light: float = 0.5, **options):
    colors = {name: np.full((HEIGHT, WIDTH), 0.5, np.float32) for name in "RGB"}
    colors["R"][4, 5] = light
    path = write_file(tmp_path / "p.exr", colors | {"Z": depth.astype(np.float32)})
    return read_plate(path, PlateOptions(**({"depth_convention": "distance"} | options)))


def ramp(value: float) -> np.ndarray:
    """Return metres from 1 to 6, one pixel of another value."""
    depth = np.broadcast_to(np.linspace(1, 6, WIDTH, dtype=np.float32), (HEIGHT, WIDTH)).copy()
    depth[10, 10] = value
    return depth


def notes_with(plate, word: str) -> list[str]:
    return [note for note in plate.notes if word in note]


def is_finite_in_all_methods(renderer, plate) -> bool:
    renderer.load(plate)
    methods = [method for method in Method if not method.needs_scene]
    kinds = ((Bokeh.DISC, Quality.PREVIEW), (Bokeh.HEAT, Quality.DRAFT))
    return all(
        np.isfinite(
            renderer.pixels(Shot(lens, DefocusSettings(bokeh, quality, method=method)))
        ).all()
        for method in methods
        for bokeh, quality in kinds
        for lens in LENSES
    )


@pytest.mark.parametrize("value", TINY)
def test_read_plate_replaces_depth_below_a_micrometer_by_neighbor(tmp_path, value):
    plate = plate_of(tmp_path, ramp(value))
    assert plate.depth_m is not None
    assert plate.depth_m[10, 10] in (ramp(1)[10, 9], ramp(1)[10, 11])
    assert plate.depth.near_m == 1.0 and plate.depth.repaired_count == 1
    assert len(notes_with(plate, "nearer than a micrometre")) == 1


@pytest.mark.parametrize("value", [DEPTH_LEAST_M * 1.01, 1e-3, 1e20, 3e38])
def test_read_plate_keeps_depth_in_range(tmp_path, value):
    plate = plate_of(tmp_path, ramp(value))
    assert plate.depth.repaired_count == 0


@pytest.mark.parametrize("value", TINY)
def test_read_plate_rejects_depth_below_a_micrometer_everywhere(tmp_path, value):
    with pytest.raises(InputError, match="nearer than a micrometre"):
        plate_of(tmp_path, np.full((HEIGHT, WIDTH), value))


@pytest.mark.parametrize("value", [1e7, 1e30, 3e38, -1e30, -3e38])
def test_read_plate_limits_circle_of_confusion_with_one_note(tmp_path, value):
    plate = plate_of(tmp_path, ramp(value) - 3, depth_convention="coc")
    assert plate.coc_px is not None
    assert plate.coc_px[10, 10] == np.copysign(COC_MOST_PX, value)
    assert len(notes_with(plate, "circle of confusion")) == 1


@pytest.mark.parametrize("value", [1e15, 1e30, 3e38, -3e38])
def test_read_plate_limits_light_with_one_note(tmp_path, value):
    plate = plate_of(tmp_path, ramp(1), light=value)
    assert plate.color[4, 5, 0] == np.float32(np.copysign(LIGHT_MOST, value))
    assert len(notes_with(plate, "light beyond")) == 1
    assert not notes_with(plate_of(tmp_path, ramp(1), light=1e9), "light beyond")


@pytest.mark.parametrize("value", [1e-30, DEPTH_LEAST_M * 1.01, 1e20, 3e38])
def test_every_method_gives_finite_image_for_extreme_depth(tmp_path, renderer, value):
    assert is_finite_in_all_methods(renderer, plate_of(tmp_path, ramp(value)))


@pytest.mark.parametrize("value", [3e38, -3e38, 1e-40])
def test_every_method_gives_finite_image_for_extreme_circle(tmp_path, renderer, value):
    plate = plate_of(tmp_path, ramp(value) - 3, depth_convention="coc")
    assert is_finite_in_all_methods(renderer, plate)


@pytest.mark.parametrize("value", [3e38, -3e38, 1e-44])
def test_every_method_gives_finite_image_for_extreme_light(tmp_path, renderer, value):
    assert is_finite_in_all_methods(renderer, plate_of(tmp_path, ramp(1), light=value))


def test_read_plate_leaves_ordinary_values_unchanged(tmp_path):
    path = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"Z": ramp(2).astype(np.float32)})
    plate = read_plate(path, PlateOptions(depth_convention="distance"))
    assert np.array_equal(plate.depth_m, ramp(2)) and plate.notes == ()
    assert np.array_equal(plate.color[..., 0], rgb(HEIGHT, WIDTH)["R"].astype(np.float32))
