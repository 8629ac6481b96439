"""What a mesh file tells in numbers: colours are sRGB, and impossible materials are the usual."""

from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.scene.mesh_read import _colors, _linear, _point_colors, _row, read_mesh

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_colours_are_decoded_as_the_standard_says():
    shares = np.float64([0, 0.04045, 0.0405, 0.5, 1])
    wanted = [0, 0.04045 / 12.92, ((0.0405 + 0.055) / 1.055) ** 2.4, 0.21404114, 1]
    assert (
        _linear(shares) == pytest.approx(wanted, rel=1e-5) and _linear(shares).dtype == np.float32
    )


@pytest.mark.parametrize(
    ("value", "found"),
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
def test_an_impossible_entry_of_a_material_is_the_usual_one(value, found):
    assert _row({"Kd": value}, "Kd", (9.0,) * 3) == found
    assert _row({}, "Kd", (9.0,) * 3) == (9.0,) * 3
    assert _row({"Ns": 7}, "Ns", (1.0,)) == (7.0,)


def geometry(kind, colors, attributes=None):
    visual = SimpleNamespace(kind=kind, **{f"{kind}_colors": colors} if kind else {})
    return SimpleNamespace(
        visual=visual,
        vertices=np.zeros((4, 3)),
        faces=np.zeros((2, 3), int),
        vertex_attributes=attributes or {},
        colors=colors,
    )


def test_colours_lie_on_vertices_or_on_each_corner_of_a_face():
    white = np.full((4, 4), 255.0)
    assert _colors(geometry("vertex", white)).shape == (4, 3)
    of_faces = _colors(geometry("face", np.array([[255, 0, 0, 255], [0, 255, 0, 0]])))
    assert of_faces.tolist() == [[1, 0, 0]] * 3 + [[0, 1, 0]] * 3  # alpha counts for nothing
    told = _colors(geometry(None, None, {"color": np.full((4, 3), 2.0)}))
    assert (told == 1.0).all()
    assert _colors(geometry("vertex", white[:3])) is None is _colors(geometry(None, None))
    assert (_point_colors(geometry(None, white)) == 1.0).all()
    assert _point_colors(geometry(None, white[:3])) is None is _point_colors(geometry(None, None))


def test_a_mesh_is_a_scene_of_one_object(tmp_path):
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
def test_what_is_no_mesh_is_named(tmp_path, name, data, words):
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=words) as error:
        read_mesh(tmp_path / name)
    assert name in str(error.value)
