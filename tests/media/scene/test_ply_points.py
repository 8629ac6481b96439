"""Test PLY files without polygons: triangle strips, and points with colors and normals."""

import struct

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.scene.point_cloud import closing_radius
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_read import read_scene

PLACES = [(i % 2, i // 2, 0) for i in range(5)]
STRIP = (0, 1, 2, 3, -1, 2, 3, 4, -1, 0)
TRIANGLES = [(0, 1, 2), (2, 1, 3), (2, 3, 4)]


def ply_header(form, count=5, strip=STRIP, more=()):
    lines = ["ply", f"format {form} 1.0", f"element vertex {count}"]
    lines += [f"property float {axis}" for axis in "xyz"] + list(more)
    if strip:
        lines += ["element tristrips 1", "property list int int vertex_indices"]
    return "\n".join([*lines, "end_header", ""]).encode()


def ply_with_strips(form):
    if form == "ascii":
        rows = [*PLACES, (len(STRIP), *STRIP)]
        return ply_header(form) + "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()
    order = "<" if "little" in form else ">"
    data = b"".join(struct.pack(f"{order}3f", *place) for place in PLACES)
    return ply_header(form) + data + struct.pack(f"{order}{len(STRIP) + 1}i", len(STRIP), *STRIP)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_strips_become_triangles_facing_one_way(tmp_path, form):
    (tmp_path / "a.ply").write_bytes(ply_with_strips(form))
    scene = read_scene(tmp_path / "a.ply")
    assert scene.triangle_count == 3 and not scene.notes
    (mesh,) = scene.meshes
    assert mesh.triangles.tolist() == [list(corners) for corners in TRIANGLES]
    assert mesh.normals == pytest.approx(np.tile((0, 0, 1), (5, 1)))


def test_ply_strip_with_missing_vertex_is_rejected(tmp_path):
    (tmp_path / "a.ply").write_bytes(ply_with_strips("ascii").replace(b"2 3 4", b"2 3 9"))
    with pytest.raises(InputError, match="does not exist"):
        read_scene(tmp_path / "a.ply")


def ply_cloud(side=12, more=(), values=()):
    y, x = np.mgrid[:side, :side] / side
    rows = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    tail = " ".join(map(str, values))
    text = "".join(f"{a:g} {b:g} {c:g} {tail}\n" for a, b, c in rows)
    return rows, ply_header("ascii", len(rows), (), more) + text.encode()


def test_ply_points_are_drawn_with_colors(tmp_path):
    more = [f"property uchar {name}" for name in ("red", "green", "blue")]
    rows, data = ply_cloud(12, more, (255, 0, 188))
    (tmp_path / "a.ply").write_bytes(data)
    scene = read_scene(tmp_path / "a.ply")
    assert scene.triangle_count == 32 * len(rows) and not scene.notes
    (mesh,) = scene.meshes
    np.testing.assert_allclose(
        mesh.colors, np.tile((1, 0, 0.502886), (96 * len(rows), 1)), atol=1e-6
    )
    low, high = bounds_m(scene, 1)
    radius = closing_radius(rows)
    assert radius == pytest.approx(0.7 / 12, rel=1e-3)
    assert (high - low)[:2] == pytest.approx(11 / 12 + 2 * radius, rel=1e-3)


def test_ply_points_with_normals_are_facing_discs(tmp_path):
    rows, data = ply_cloud(6, [f"property float n{axis}" for axis in "xyz"], (0, 0, -2))
    (tmp_path / "a.ply").write_bytes(data)
    (mesh,) = read_scene(tmp_path / "a.ply").meshes
    assert len(mesh.triangles) == 2 * len(rows)
    assert (mesh.normals == (0, 0, -1)).all() and np.ptp(mesh.positions_m[:, 2]) == 0


def test_ply_points_without_position_are_left_out_with_a_note(tmp_path):
    rows, data = ply_cloud(4)
    (tmp_path / "a.ply").write_bytes(data.replace(b"0 0 0", b"nan 0 0", 1))
    scene = read_scene(tmp_path / "a.ply")
    assert (
        scene.triangle_count == 32 * (len(rows) - 1)
        and "1 points have no valid position" in scene.notes[0]
    )


@pytest.mark.parametrize("order", ["<", ">"])
def test_ply_polygons_are_split_into_triangles(tmp_path, order):
    """The layout is Blender's, with an entry for each face after its corners."""
    words = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    more = ["element face 3", "property list uchar uint vertex_indices", "property uchar flags"]
    data = b"".join(struct.pack(f"{order}3f", *place) for place in PLACES)
    for polygon in ((0, 1, 3, 2), (2, 3, 4), (0, 1, 3, 4, 2)):
        data += struct.pack(f"{order}B{len(polygon)}IB", len(polygon), *polygon, 7)
    (tmp_path / "a.ply").write_bytes(ply_header(words, 5, (), more) + data)
    (mesh,) = read_scene(tmp_path / "a.ply").meshes
    found = sorted(map(tuple, mesh.triangles.tolist()))
    fans = [(0, 1, 3), (0, 3, 2), (2, 3, 4), (0, 1, 3), (0, 3, 4), (0, 4, 2)]
    assert found == sorted(fans)


def test_ply_truncated_polygons_are_reported(tmp_path):
    more = ["element face 2", "property list uchar uint vertex_indices"]
    data = b"".join(struct.pack("<3f", *place) for place in PLACES)
    data += struct.pack("<B4I", 4, 0, 1, 3, 2) + struct.pack("<B2I", 3, 2, 3)
    (tmp_path / "a.ply").write_bytes(ply_header("binary_little_endian", 5, (), more) + data)
    with pytest.raises(InputError, match=r"a\.ply is damaged"):
        read_scene(tmp_path / "a.ply")


def test_ply_splats_are_noted_and_keep_colors(tmp_path):
    """Programs write zero normals with splats, which give no disc a direction."""
    names = ("nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "rot_0")
    more = [f"property float {name}" for name in names]
    rows, data = ply_cloud(4, more, (0, 0, 0, 1.7724539, -1.7724539, 0.0, 1, 0, 1))
    (tmp_path / "a.ply").write_bytes(data)
    scene = read_scene(tmp_path / "a.ply")
    (mesh,) = scene.meshes
    assert any("Gaussian splats" in note for note in scene.notes)
    assert scene.triangle_count == 32 * len(rows)
    np.testing.assert_allclose(mesh.colors[0], (1.0, 0.0, 0.214041), atol=1e-4)
