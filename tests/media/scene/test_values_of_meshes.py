"""Numbers in mesh files: colors are sRGB, and invalid values of materials become the defaults."""

from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.scene.mesh_read import (
    _decode_srgb,
    _point_colors,
    _read_row,
    _vertex_colors,
    read_mesh,
)

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_decode_srgb_follows_standard_curve():
    shares = np.float64([0, 0.04045, 0.0405, 0.5, 1])
    expected = [0, 0.04045 / 12.92, ((0.0405 + 0.055) / 1.055) ** 2.4, 0.21404114, 1]
    assert (
        _decode_srgb(shares) == pytest.approx(expected, rel=1e-5)
        and _decode_srgb(shares).dtype == np.float32
    )


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ([1, 0.5, 0], (1.0, 0.5, 0.0)),
        ([0, 0, 1e6], (9.0,) * 3),
        ([0, -0.1, 0], (9.0,) * 3),
        ([1, 2], (9.0,) * 3),
        (["x", 1, 1], (9.0,) * 3),
        ([np.nan, 1, 1], (9.0,) * 3),
        (None, (9.0,) * 3),
    ],
)
def test_read_row_replaces_invalid_material_value_by_default(value, expected):
    assert _read_row({"Kd": value}, "Kd", (9.0,) * 3) == expected
    assert _read_row({}, "Kd", (9.0,) * 3) == (9.0,) * 3
    assert _read_row({"Ns": 7}, "Ns", (1.0,)) == (7.0,)


def geometry(kind, colors, attributes=None):
    visual = SimpleNamespace(kind=kind, **{f"{kind}_colors": colors} if kind else {})
    return SimpleNamespace(
        visual=visual,
        vertices=np.zeros((4, 3)),
        faces=np.zeros((2, 3), int),
        vertex_attributes=attributes or {},
        colors=colors,
    )


def test_vertex_colors_are_read_from_vertices_faces_or_attributes():
    white = np.full((4, 4), 255.0)
    assert _vertex_colors(geometry("vertex", white)).shape == (4, 3)
    of_faces = _vertex_colors(geometry("face", np.array([[255, 0, 0, 255], [0, 255, 0, 0]])))
    assert of_faces.tolist() == [[1, 0, 0]] * 3 + [[0, 1, 0]] * 3  # alpha is ignored
    of_attribute = _vertex_colors(geometry(None, None, {"color": np.full((4, 3), 2.0)}))
    assert (of_attribute == 1.0).all()
    assert (
        _vertex_colors(geometry("vertex", white[:3]))
        is None
        is _vertex_colors(geometry(None, None))
    )
    assert (_point_colors(geometry(None, white)) == 1.0).all()
    assert _point_colors(geometry(None, white[:3])) is None is _point_colors(geometry(None, None))


def test_read_mesh_returns_scene_of_one_instance(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("o wedge\n" + TRIANGLE)
    scene = read_mesh(path)
    (mesh,), (instance,) = scene.meshes, scene.instances
    assert len(mesh.triangles) == 1 and instance.name and scene.notes == ()
    assert scene.frames is None


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.obj", b"", "is empty"),
        ("a.stl", b"x" * 90, "STL"),
        ("a.ply", b"ply\nformat", "PLY"),
        ("gone.obj", None, "gone.obj"),
    ],
)
def test_read_mesh_names_file_that_is_no_mesh(tmp_path, name, data, words):
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=words) as error:
        read_mesh(tmp_path / name)
    assert name in str(error.value)
