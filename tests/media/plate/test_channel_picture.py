"""Channels of a file as pictures: which belong together, and how their values are shown."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.plate.channel_picture import channel_choices, read_channel
from support.exr_files import rgb, write_file

SHAPE = 6, 8


@pytest.fixture
def path(tmp_path, rng):
    normals = rng.normal(size=(*SHAPE, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    ids = rng.integers(0, 4, SHAPE).astype(np.uint32)
    depth = rng.uniform(1.0, 9.0, SHAPE).astype(np.float32)
    depth[0, 0] = np.inf
    vectors = {f"N.{leaf}": normals[..., index] for index, leaf in enumerate("XYZ")}
    channels = rgb(*SHAPE) | {"Z": depth} | vectors | {"objectId": ids}
    write_file(tmp_path / "p.exr", channels)
    return tmp_path / "p.exr"


def test_channels_of_a_vector_are_one_choice():
    names = ("A", "B", "G", "R", "N.X", "N.Y", "N.Z", "objectId", "fog.R", "fog.G", "Z")
    assert channel_choices(names) == (
        *("A", "B", "G", "R", "N", "objectId", "fog.R", "fog.G", "Z"),
    )


def test_normals_are_shown_around_grey_and_read_as_they_are(path):
    picture = read_channel(path, "N")
    assert picture.names == ("N.X", "N.Y", "N.Z")
    np.testing.assert_allclose(picture.pixels[..., :3], 0.5 + 0.5 * picture.values, atol=1e-6)
    x, y, z = picture.values[2, 3]
    assert picture.words_at(2, 3) == f"N.X {x:.6g}  N.Y {y:.6g}  N.Z {z:.6g}"


def test_each_id_has_one_color_of_its_own_and_none_is_black(path):
    picture = read_channel(path, "objectId")
    ids, pixels = picture.values[..., 0], picture.pixels[..., :3]
    colors = {
        int(it): {tuple(color) for color in pixels[ids == it].tolist()} for it in set(ids.flat)
    }
    assert all(len(of_id) == 1 for of_id in colors.values())
    assert len(set.union(*colors.values())) == len(colors) and colors[0] == {(0.0, 0.0, 0.0)}


def test_numbers_go_from_black_to_white_in_their_order(path):
    picture = read_channel(path, "Z")
    depth, grey = picture.values[..., 0], picture.pixels[..., 0]
    order = np.argsort(depth, axis=None)
    assert np.all(np.diff(grey.flat[order]) >= 0)
    assert grey.min() == 0.0 and grey.max() == 1.0 and np.isfinite(picture.pixels).all()


def test_missing_channel_is_refused_with_its_name(path):
    with pytest.raises(InputError, match="no channel velocity"):
        read_channel(path, "velocity")
