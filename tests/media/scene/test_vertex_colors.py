"""Vertex colors: how they are read from files, and how raster and ray tracer show them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pxr import Sdf, Usd, UsdGeom, UsdShade

from heatlens.core.base.errors import InputError
from heatlens.media.scene.material import Material
from heatlens.media.scene.mesh_make import make_mesh
from heatlens.media.scene.scene import Mesh
from heatlens.media.scene.scene_read import read_scene
from heatlens.media.scene.usd.read import usd_scene
from heatlens.render.scene_gpu.scene_buffers import SceneBuffers
from heatlens.render.scene_gpu.scene_records import colors_of
from support.gltf_files import GltfWriter
from support.scenes import lamp, placement, plane, scene_of, sphere, still_life

SHARES = np.array([[0, 0.2, 1, 0.4], [1, 0.6, 0.2, 1], [0.4, 0, 0, 0], [1, 1, 1, 0.8]])
KINDS = {"f4": 1, "u1": 255, "u2": 65535}


@pytest.mark.parametrize("width", [3, 4])
@pytest.mark.parametrize("is_normalized", [True, False])
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_gltf_colors_of_every_number_type_are_equal(tmp_path, kind, is_normalized, width):
    writer = GltfWriter()
    values = (SHARES[:, :width] * KINDS[kind]).astype(kind)  # fifths of 255 are whole
    writer.node(mesh=writer.mesh(attributes={"COLOR_0": values}))
    if is_normalized:
        writer.json["accessors"][0]["normalized"] = True
    scene = read_scene(writer.write(tmp_path / "a.glb"))
    mesh = scene.meshes[0]
    found = mesh.colors[mesh.triangles]
    expected = SHARES[[0, 1, 2, 0, 2, 3], :width].reshape(2, 3, width)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert not any("olour" in note for note in scene.notes)


@pytest.mark.parametrize(
    ("values", "message"),
    [(SHARES[:3].astype("f4"), "3 of COLOR_0"), (SHARES[:, :2].astype("f4"), "VEC2")],
)
def test_gltf_colors_of_wrong_count_or_shape_are_rejected(tmp_path, values, message):
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(attributes={"COLOR_0": values}))
    with pytest.raises(InputError, match=message):
        read_scene(writer.write(tmp_path / "a.glb"))


@given(hnp.arrays(np.float32, (3, 4), elements=st.floats(width=32)))
def test_make_mesh_clips_vertex_colors_to_zero_and_one(values):
    positions, triangles = np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32)
    colors = make_mesh("a", positions, triangles, colors=values).colors
    usable = (values >= 0) & (values <= 1)
    if colors is None:
        assert (values[usable] == 1).all()
        return
    assert ((colors >= 0) & (colors <= 1)).all()
    assert np.array_equal(colors[usable], values[usable])


USD_POINTS = [(0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0), (0.5, 3, 0)]
USD_CORNERS = [0, 1, 2, 3, 3, 2, 4]
USD_FACES = [0, 0, 0, 0, 1, 1, 1]  # of each corner


@pytest.mark.parametrize(
    ("kind", "count", "places"),
    [
        ("vertex", 5, USD_CORNERS),
        ("varying", 5, USD_CORNERS),
        ("faceVarying", 7, range(7)),
        ("uniform", 2, USD_FACES),
    ],
)
@pytest.mark.parametrize("has_indices", [False, True])
def test_usd_colors_of_every_interpolation_are_read(tmp_path, kind, count, places, has_indices):
    tints = np.linspace(0, 1, 3 * count).reshape(-1, 3).round(3)
    path = tmp_path / "a.usda"
    stage = usd_stage(path, kind, tints[::-1] if has_indices else tints)
    if has_indices:
        primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/house")).GetPrimvar("displayColor")
        primvar.SetIndices(list(range(count))[::-1])
    stage.Save()
    scene = usd_scene(str(path))
    mesh = scene.meshes[0]
    found = mesh.colors[mesh.triangles]
    corners = np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6)])
    np.testing.assert_allclose(found, tints[np.array(places)[corners]], atol=1e-6)
    assert scene.materials[mesh.material].base_color == (1, 1, 1)


def usd_stage(path, kind, tints):
    stage = Usd.Stage.CreateNew(str(path))
    mesh = UsdGeom.Mesh.Define(stage, "/house")
    mesh.CreatePointsAttr(USD_POINTS)
    mesh.CreateFaceVertexCountsAttr([4, 3])
    mesh.CreateFaceVertexIndicesAttr(USD_CORNERS)
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateDisplayColorPrimvar(kind).Set([tuple(map(float, tint)) for tint in tints])
    return stage


def test_usd_material_replaces_colors_and_constant_color_is_material(tmp_path):
    stage = usd_stage(tmp_path / "a.usda", "vertex", np.full((5, 3), 0.5))
    material = UsdShade.Material.Define(stage, "/brick")
    surface = UsdShade.Shader.Define(stage, "/brick/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((0.1, 0.2, 0.3))
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/house")).Bind(material)
    stage.Save()
    assert usd_scene(str(tmp_path / "a.usda")).meshes[0].colors is None
    usd_stage(tmp_path / "b.usda", "constant", [(0.5, 0.25, 0)]).Save()
    scene = usd_scene(str(tmp_path / "b.usda"))
    assert scene.meshes[0].colors is None
    assert scene.materials[scene.meshes[0].material].base_color == (0.5, 0.25, 0)


# Rendered pictures

TINT = (0.25, 0.5, 0.875)


def with_vertex_colors(mesh: Mesh, colors) -> Mesh:
    """Return the mesh with one color for all vertices, or with one for each."""
    shape = (len(mesh.positions_m), np.shape(colors)[-1])
    return replace(mesh, colors=np.broadcast_to(np.float32(colors), shape))


@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_vertex_color_multiplies_material_color(stage, metallic):
    material = Material(base_color=(0.5, 1.0, 0.25), metallic=metallic)
    product = replace(material, base_color=tuple(np.multiply(material.base_color, TINT)))
    found = stage.seen(scene_of([with_vertex_colors(sphere(0.8), TINT)], materials=[material]))
    expected = stage.seen(scene_of([sphere(0.8)], materials=[product]))
    for seen, same in zip(found, expected, strict=True):
        np.testing.assert_allclose(seen, same, rtol=2e-3, atol=1e-4)
    plain = stage.seen(scene_of([sphere(0.8)], materials=[material]))
    assert np.abs(found[0] - plain[0]).max() > 0.05


def test_mesh_without_colors_is_unchanged_beside_colored_mesh(stage):
    left, right = placement(-0.8, scale=0.5), placement(0.8, scale=0.5)
    alone = scene_of([sphere(), sphere()], [(0, left), (1, right)])
    with_white_sphere = replace(alone, meshes=(with_vertex_colors(sphere(), TINT), sphere()))
    for seen, before in zip(stage.seen(with_white_sphere), stage.seen(alone), strict=True):
        np.testing.assert_allclose(seen[:, 16:], before[:, 16:], atol=1e-5)
        assert np.abs(seen[:, :16] - before[:, :16]).max() > 0.05


def test_vertex_color_gradient_is_same_in_ray_tracer_and_raster(stage):
    colors = [(0, 0, 0, 1), (1, 0, 0, 1), (1, 1, 0, 1), (0, 1, 0, 1)]  # red across, green up
    white = Material(base_color=(1.0, 1.0, 1.0), roughness=1.0)
    drawn, traced = stage.seen(
        scene_of([with_vertex_colors(plane(0.7), colors)], materials=[white])
    )
    np.testing.assert_allclose(drawn, traced, rtol=5e-3, atol=2e-3)
    inside = drawn[8:24, 8:24]
    assert (np.diff(inside[..., 0], axis=1) > 0).all()
    assert (np.diff(inside[..., 1], axis=0) < 0).all()  # rows run down


def test_vertex_opacity_below_cutoff_is_hole_in_ray_tracer_and_raster(stage):
    colors = [(1, 1, 1, alpha) for alpha in (0, 1, 1, 0)]
    sheet = with_vertex_colors(plane(0.7), colors)
    cut = replace(lamp((9.0, 9.0, 9.0)), alpha_cutoff=0.5)  # the sky is far darker
    for seen in stage.seen(scene_of([sheet], materials=[cut])):
        assert (seen[:, :15] < 2).all() and (seen[10:22, 17:25] > 8).all()
    for seen in stage.seen(scene_of([sheet], materials=[replace(cut, alpha_cutoff=0.0)])):
        assert (seen[10:22, 7:25] > 8).all()


def test_scene_buffers_without_vertex_colors_have_no_color_buffer(ctx):
    buffers = SceneBuffers(ctx, still_life())
    assert buffers.colors is None and "COLORS" not in buffers.defines
    buffers.release()


def test_colors_of_fills_missing_vertex_colors_with_white():
    meshes = [plane(), with_vertex_colors(plane(), TINT), with_vertex_colors(plane(), (*TINT, 0.5))]
    found = np.frombuffer(colors_of(meshes), np.float16).reshape(3, 4, 4)
    expected = [(1, 1, 1, 1), (*TINT, 1), (*TINT, 0.5)]
    assert np.array_equal(found, np.tile(np.array(expected)[:, None], (1, 4, 1)))
