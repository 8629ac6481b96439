"""Test deep EXR files: what a pixel shows, the surfaces behind it, and impossible samples."""

import itertools

import numpy as np
import OpenEXR
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.compared_pictures import read_picture
from heatlens.media.frame_cache.plate_shelf import plate_bytes
from heatlens.media.plate.deep.fragment_merge import FRAGMENTS_MOST
from heatlens.media.plate.read import read_plate
from heatlens.render.source.plate_source import black_plate
from support.deep_files import Sample, write_deep
from support.exr_files import window, write_file, write_parts

SAMPLES = st.tuples(
    st.integers(0, 8).map(lambda i: i / 8),
    st.sampled_from([0.25, 0.5, 1.0]),
    st.sampled_from([1.0, 1.5, 2.0, 3.0, 7.0, 1e10]),
)


def composite_over(samples: list[Sample]) -> tuple[float, float]:
    """Return premultiplied grey and coverage of samples over each other."""
    grey, cover = 0.0, 0.0
    for light, part, _ in sorted(samples, key=lambda sample: sample[2]):
        grey, cover = grey + (1 - cover) * light, cover + (1 - cover) * part
    return grey, cover


def list_of_pixel(plate, pixel: int) -> tuple[bool, np.ndarray, np.ndarray]:
    """Return whether the list begins with the visible surface, and its distances and coverages."""
    lists = plate.fragments
    first, end = lists.begins[pixel : pixel + 2]
    with np.errstate(divide="ignore"):
        distances = 1 / lists.dioptres[first:end]
    return bool(lists.has_front[pixel]), distances, lists.coverage[first:end]


def test_deep_plate_of_one_opaque_sample_equals_flat_plate(tmp_path):
    pixels = [[(i / 16, 1.0, 2 + i / 4)] for i in range(12)]
    deep = read_plate(write_deep(tmp_path / "deep.exr", pixels, (3, 4)))
    grey = (np.arange(12, dtype=np.float32) / 16).reshape(3, 4)
    flat_channels = dict.fromkeys("RGB", grey) | {"Z": 2 + grey * 4}
    flat = read_plate(write_file(tmp_path / "flat.exr", flat_channels))
    assert np.array_equal(deep.color, flat.color) and np.array_equal(deep.depth_m, flat.depth_m)
    assert deep.fragments is None and not deep.has_alpha
    assert deep.data_window == flat.data_window and deep.display_window == flat.display_window


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(st.lists(st.lists(SAMPLES, max_size=5, unique_by=lambda s: s[2]), min_size=4, max_size=4))
def test_read_plate_composites_deep_samples_over_each_other(tmp_path, pixels):
    pixels = [[(light * part, part, z) for light, part, z in samples] for samples in pixels]
    plate = read_plate(write_deep(tmp_path / "deep.exr", pixels, (2, 2)))
    for pixel, samples in enumerate(pixels):
        shown = plate.color.reshape(4, 4)[pixel, [0, 3]]
        np.testing.assert_allclose(shown, composite_over(samples), atol=1e-5)
        nearest = min((z for *_, z in samples), default=1e10)
        assert plate.depth_m.ravel()[pixel] == (np.inf if nearest >= 1e10 else nearest)


def test_read_plate_lists_deep_samples_behind_from_near_to_far(tmp_path):
    pixels = [
        [(0.5, 1.0, 2.0), (0.1, 0.5, 4.0), (0.7, 1.0, 9.0)],
        [(0.1, 0.5, 3.0), (0.7, 1.0, 9.0)],
    ]
    plate = read_plate(write_deep(tmp_path / "deep.exr", pixels, (1, 2)))
    has_front, distances, coverages = list_of_pixel(plate, 0)
    assert not has_front  # an opaque first sample is the plate's own pixel, and is not listed
    np.testing.assert_allclose(distances, [4, 9], rtol=1e-6)
    np.testing.assert_allclose(coverages, [0.5, 1])
    has_front, distances, coverages = list_of_pixel(plate, 1)
    assert has_front and plate.fragments.is_measured
    np.testing.assert_allclose(distances, [3, 9], rtol=1e-6)


def test_read_plate_merges_deep_samples_of_one_surface(tmp_path):
    samples = [(0.25, 0.5, 2.005), (0.25, 0.5, 2.006), (0.3, 1.0, 5.0)]
    plate = read_plate(write_deep(tmp_path / "deep.exr", [samples], (1, 1)))
    _, distances, coverages = list_of_pixel(plate, 0)
    np.testing.assert_allclose(coverages, [0.75, 1.0], atol=1e-3)
    np.testing.assert_allclose(distances, [2.0053, 5.0], rtol=1e-3)


def test_deep_sample_depth_is_middle_of_veil_and_front_of_wall(tmp_path):
    pixels = [[(0.25, 0.5, 2.0), (0.5, 1.0, 6.0)]]
    plate = read_plate(write_deep(tmp_path / "deep.exr", pixels, (1, 1), thickness=0.25))
    np.testing.assert_allclose(list_of_pixel(plate, 0)[1], [2.125, 6.0], rtol=1e-6)


@pytest.mark.parametrize(("near", "far"), [(2.0, 8.0), (0.0, 3.0), (-2.0, 3.0), (1.0, 1.3)])
def test_read_plate_cuts_fog_into_slices_of_same_transmission(tmp_path, near, far):
    """The light that passes between two depths depends on the length of fog between them."""
    fog = (0.3 * 0.6, 0.6, near)
    pixels = [[fog, (0.5, 1.0, 20.0)]]
    plate = read_plate(write_deep(tmp_path / "fog.exr", pixels, (1, 1), thickness=far - near))
    _, distances, coverages = list_of_pixel(plate, 0)
    slices = distances[:-1]
    assert len(slices) > 1 and (np.diff(slices) > 0).all()
    assert near < slices[0] < slices[-1] < far
    transmission = np.prod(1 - coverages[:-1].astype(float))
    assert transmission == pytest.approx(0.4, abs=2e-3)
    np.testing.assert_allclose(plate.color[0, 0, 0], 0.18 + 0.4 * 0.5, rtol=1e-3)
    assert "1 of 2 samples are thick" in " ".join(plate.notes)


def test_read_plate_notes_impossible_deep_samples(tmp_path):
    pixels = [
        [(0.5, 1.0, 5.0), (0.5, 1.0, 2.0)],
        [(0.5, 1.0, np.nan), (0.25, 1.0, 3.0)],
        [(np.nan, 2.0, 4.0)],
        [(0.5, 1.0, -1.0), (0.5, 1.0, 0.0)],
    ]
    plate = read_plate(write_deep(tmp_path / "deep.exr", pixels, (2, 2)))
    notes = " ".join(plate.notes)
    assert "3 of 7 samples have an impossible distance" in notes
    assert "1 of 7 samples have an impossible colour or coverage" in notes
    assert "2 of 7 samples were not sorted" in notes
    assert np.isfinite(plate.color).all() and list(plate.depth_m.ravel()) == [2, 3, 4, np.inf]


def test_read_plate_merges_thousands_of_similar_deep_samples(tmp_path):
    distances = np.geomspace(1.0, 100.0, 10_000)
    samples = [(0.3 * 0.001, 0.001, float(z)) for z in distances]
    plate = read_plate(write_deep(tmp_path / "deep.exr", [samples, samples[:1]], (1, 2)))
    _, _, coverages = list_of_pixel(plate, 0)
    assert 2 < len(coverages) <= FRAGMENTS_MOST
    np.testing.assert_allclose(plate.color[0, 0, [0, 3]], composite_over(samples), rtol=1e-3)
    assert "1 pixels have more than" in " ".join(plate.notes)


@pytest.mark.parametrize("part", [0.2, 0.6, 0.95])
def test_read_plate_rejects_truncated_deep_file(tmp_path, part):
    pixels = [[(0.5, 1.0, 2.0 + i), (0.3, 1.0, 90.0)] for i in range(64)]
    path = write_deep(tmp_path / "deep.exr", pixels, (8, 8))
    data = path.read_bytes()
    path.write_bytes(data[: int(part * len(data))])
    with pytest.raises(InputError, match=r"deep\.exr"):
        read_plate(path)


@pytest.mark.parametrize(
    ("options", "message_part"),
    [
        (PlateOptions(depth_convention="inverse"), "--depth-convention"),
        (PlateOptions(depth_kind="radial"), "--depth-kind"),
        (PlateOptions(depth_source="z.exr"), "--depth, --depth-channel"),
        (PlateOptions(depth_channel="Z"), "--depth-channel"),
        (PlateOptions(color_layer="sub"), "lacks some of R, G, B, A and Z in the layer 'sub'"),
    ],
)
def test_read_plate_rejects_options_that_deep_files_cannot_follow(tmp_path, options, message_part):
    path = write_deep(tmp_path / "deep.exr", [[(0.5, 1.0, 2.0)]], (1, 1))
    with pytest.raises(InputError, match=message_part):
        read_plate(path, options)


def test_info_describes_deep_file(tmp_path, capsys):
    pixels = [[(0.5, 1.0, 2.0), (0.3, 1.0, 9.0)]] * 4
    path = write_deep(tmp_path / "deep.exr", pixels, (2, 2))
    assert main(["info", str(path)]) == 0
    stdout = capsys.readouterr().out
    assert "deep samples" in stdout and "2.00 surfaces a pixel" in stdout and "2 to 2 m" in stdout
    lines = {line[:16].strip(): line[16:] for line in stdout.splitlines()}
    assert lines["part 1"] == "deepscanline, zips" and lines["float"] == "A, B, G, R, Z"


# Layers and views


def deep_layer(prefix: str, light: float, metres: float) -> dict[str, np.ndarray]:
    """Return one opaque sample a pixel of 2 x 3, in a layer."""
    values = {"R": light, "G": light, "B": light, "A": 1.0, "Z": metres}
    channels = {prefix + name: np.empty((2, 3), object) for name in values}
    for name, value in values.items():
        for at in np.ndindex(2, 3):
            channels[prefix + name][at] = np.array([value], np.float32)
    return channels


DEEP = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}


def test_read_plate_takes_chosen_layer_of_deep_file(tmp_path):
    path = write_file(
        tmp_path / "layers.exr", deep_layer("", 0.5, 2) | deep_layer("smoke.", 0.25, 7), **DEEP
    )
    assert read_plate(path).depth_m[0, 0] == 2
    smoke = read_plate(path, PlateOptions(color_layer="smoke"))
    assert smoke.depth_m[0, 0] == 7 and smoke.color[0, 0, 0] == 0.25
    assert smoke.depth.channel == "smoke.Z"


def test_read_plate_takes_chosen_eye_of_deep_file(tmp_path):
    parts = [
        (DEEP | {"name": eye, "view": eye}, deep_layer("", light, metres))
        for eye, light, metres in (("left", 0.5, 2), ("right", 0.25, 7))
    ]
    path = write_parts(tmp_path / "eyes.exr", *parts)
    left, right = read_plate(path), read_plate(path, PlateOptions(eye="right"))
    assert left.depth_m[0, 0] == 2 and right.depth_m[0, 0] == 7
    assert left.views == ("left", "right") and right.attributes["view"] == "right"
    assert "--eye right takes the other" in " ".join(left.notes)


def test_deep_file_can_be_read_as_picture_and_as_depth_source(tmp_path):
    grey = np.full((2, 3), 0.5, np.float32)
    deep = write_file(tmp_path / "deep.exr", deep_layer("", 0.5, 2), **DEEP)
    flat = write_file(tmp_path / "flat.exr", dict.fromkeys("RGB", grey))
    assert (read_picture(deep).rgb == 0.5).all()
    plate = read_plate(flat, PlateOptions(depth_source=str(deep)))
    assert (plate.depth_m == 2).all()


# Deep files and pictures behind together


def write_flat_wall(path, metres: float, light: float):
    grey = np.full((2, 2), light, np.float32)
    return write_file(path, dict.fromkeys("RGB", grey) | {"Z": np.full((2, 2), metres, np.float32)})


def assert_same_plates(one, other) -> None:
    assert np.array_equal(one.color, other.color)
    assert np.array_equal(one.depth_m, other.depth_m)
    assert np.array_equal(one.fragments.starts, other.fragments.starts)
    assert np.array_equal(one.fragments.words, other.fragments.words)


def test_deep_plate_with_wall_behind_equals_deep_file_with_wall(tmp_path):
    fronts = [[(0.25, 0.5, 2.0)], [(0.5, 1.0, 3.0)], [], [(0.5, 0.75, 9.5), (0.5, 1.0, 12.0)]]
    front = write_deep(tmp_path / "front.exr", fronts, (2, 2))
    wall = write_flat_wall(tmp_path / "wall.exr", 9.0, 0.75)
    both = write_deep(tmp_path / "both.exr", [[*f, (0.75, 1.0, 9.0)] for f in fronts], (2, 2))
    plate_with_wall = read_plate(front, PlateOptions(behind=(str(wall),)))
    assert_same_plates(plate_with_wall, read_plate(both))
    assert (
        plate_with_wall.behind[-1].hidden_part == 0.5
        and plate_with_wall.behind[-1].seen_part == 0.5
    )


def test_read_plate_does_not_depend_on_order_of_behind_files(tmp_path):
    texts = [
        str(write_deep(tmp_path / "a.exr", [[(0.2, 0.5, 4.0), (0.5, 1.0, 8.0)]] * 4, (2, 2))),
        str(write_deep(tmp_path / "b.exr", [[(0.25, 0.5, 4.0)]] * 4, (2, 2))),
        str(write_flat_wall(tmp_path / "c.exr", 6.0, 0.75)),
    ]
    front = write_flat_wall(tmp_path / "front.exr", 1.0, 0.5)
    first, *others = (
        read_plate(front, PlateOptions(behind=order)) for order in itertools.permutations(texts)
    )
    for other in others:
        assert_same_plates(first, other)


def test_deep_behind_file_is_placed_by_its_data_window(tmp_path):
    small = write_deep(
        tmp_path / "small.exr",
        [[(0.2, 0.5, 4.0), (0.5, 1.0, 8.0)], [(0.75, 1.0, 5.0)]],
        (1, 2),
        dataWindow=window(1, 1, 3, 2),
        displayWindow=window(0, 0, 2, 2),
    )
    front = write_flat_wall(tmp_path / "front.exr", 1.0, 0.5)
    plate = read_plate(front, PlateOptions(behind=(str(small),)))
    assert np.diff(plate.fragments.begins).tolist() == [0, 0, 0, 2]
    np.testing.assert_allclose(list_of_pixel(plate, 3)[1], [4.0, 8.0], rtol=1e-6)


@given(st.lists(SAMPLES, min_size=1, max_size=5, unique_by=lambda s: s[2]), st.integers(0, 4))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25)
def test_repeated_opaque_deep_sample_changes_nothing(tmp_path, samples, which):
    samples = [
        (light, 1.0 if k == which else part, z) for k, (light, part, z) in enumerate(samples)
    ]
    twice = [*samples, *samples[which : which + 1]]
    once, again = (
        read_plate(
            write_deep(tmp_path / "deep.exr", [pixel, [(0.5, 0.5, 1.0), (0.5, 1.0, 9.0)]], (1, 2))
        )
        for pixel in (samples, twice)
    )
    assert_same_plates(once, again)


def test_read_plate_merges_excess_surfaces_of_similar_blur(tmp_path):
    """Sixty distances near the lens stay apart; three far ones of similar blur are merged."""
    distances = np.append(1 / np.linspace(1.0, 0.2, 60), [50.0, 60.0, 70.0])
    samples = [(0.03, 0.1, float(z)) for z in distances]
    plate = read_plate(write_deep(tmp_path / "deep.exr", [samples, []], (1, 2)))
    _, listed_m, coverages = list_of_pixel(plate, 0)
    assert len(listed_m) <= FRAGMENTS_MOST
    gaps = -np.diff(1 / listed_m)
    assert (
        gaps.max() < 0.25 and listed_m[-1] > 50 and coverages[-1] == pytest.approx(0.271, abs=1e-3)
    )
    assert "up to 63" in " ".join(plate.notes)


ANY = st.floats(width=32)
NEAR_ONE = st.floats(-0.5, 1.5, width=32)
DISTANCE = ANY | st.floats(0, 16, width=32)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(st.lists(st.tuples(ANY, ANY | NEAR_ONE, DISTANCE, DISTANCE), max_size=20))
def test_any_deep_samples_give_finite_plate_with_sorted_lists(tmp_path, samples):
    channels = {}
    for name, column in {"R": 0, "G": 0, "B": 0, "A": 1, "Z": 2, "ZBack": 3}.items():
        channels[name] = np.empty((1, 1), object)
        channels[name][0, 0] = np.array([sample[column] for sample in samples], np.float32)
    plate = read_plate(write_file(tmp_path / "any.exr", channels, **DEEP))
    assert np.isfinite(plate.color).all() and plate.depth_m[0, 0] > 0
    assert 0 <= plate.color[0, 0, 3] <= 1
    if plate.fragments is not None:
        lists = plate.fragments
        assert np.isfinite(lists.color).all() and np.isfinite(lists.dioptres).all()
        assert (np.diff(lists.dioptres) <= 0).all() and lists.count <= FRAGMENTS_MOST
        assert (0 < lists.coverage).all() and (lists.coverage <= 1).all()


def test_plate_bytes_count_fragments_and_black_plate_has_none(tmp_path):
    samples = [[(0.5, 1.0, 2.0), (0.5, 1.0, 9.0)]] * 4
    plate = read_plate(write_deep(tmp_path / "deep.exr", samples, (2, 2)))
    pixels, starts, fragments = 4 * (4 + 1) * 4, 5 * 4, 4 * 12
    assert plate_bytes(plate) == pixels + starts + fragments
    assert black_plate(plate).fragments is None
