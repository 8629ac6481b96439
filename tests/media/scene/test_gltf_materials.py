"""Test glTF materials beyond the core model, and the notes on those left out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.media.scene.gltf.gloss_pictures import convert_gloss_pictures, convert_specular
from heatlens.media.scene.point_cloud import POINTS_MOST
from heatlens.media.scene.scene_read import read_scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.raster import SceneRaster
from support.gltf_files import SQUARE_UVS, GltfWriter, square_scene

GLOSSY = "KHR_materials_pbrSpecularGlossiness"
shares = st.tuples(*[st.floats(0, 1)] * 3)


def read_square(tmp_path, writer=None, /, **material):
    """Read a square with this material."""
    writer = writer or GltfWriter()
    number = writer.add("materials", **material)
    attributes = {"TEXCOORD_0": SQUARE_UVS, "TEXCOORD_1": SQUARE_UVS / 2}
    writer.node(mesh=writer.mesh(attributes=attributes, material=number))
    return read_scene(writer.write(tmp_path / "a.glb"))


def test_gltf_unlit_material_is_not_lit(tmp_path):
    shine = {"baseColorFactor": [0.2, 0.4, 0.6, 1]}
    unlit = {"KHR_materials_unlit": {}}
    scene = read_square(tmp_path, pbrMetallicRoughness=shine, extensions=unlit)
    assert not scene.materials[0].is_lit and scene.materials[1].is_lit
    assert scene.materials[0].base_color == (0.2, 0.4, 0.6) and not scene.notes


def test_convert_specular_recovers_paint_and_metal():
    """Paint reflects 4 % and a metal has no diffuse color; these two cases are exact."""
    paint, gold = np.array([0.8, 0.3, 0.1]), np.array([1.0, 0.77, 0.34])
    metal, base = convert_specular(np.stack([paint, 0 * gold]), np.stack([0 * paint + 0.04, gold]))
    assert metal == pytest.approx([0, 1], abs=0.01)
    np.testing.assert_allclose(base, [paint, gold], atol=0.02)


@given(shares, shares)
def test_convert_specular_of_any_glossy_values_is_in_range(diffuse, specular):
    metal, base = convert_specular(np.array(diffuse), np.array(specular))
    assert 0 <= metal <= 1
    assert (base >= 0).all() and (base <= 1).all()


def test_glossy_factors_and_textures_give_same_material(tmp_path):
    factors = {"diffuseFactor": [0.5, 0.1, 0.1, 0.25], "specularFactor": [0.3, 0.3, 0.3]}
    extensions = {GLOSSY: factors | {"glossinessFactor": 0.75}}
    plain = read_square(tmp_path, extensions=extensions, alphaMode="BLEND").materials[0]
    assert (plain.roughness, plain.base_alpha) == (pytest.approx(0.25), 0.25)
    writer = GltfWriter()
    extensions[GLOSSY]["diffuseTexture"] = {"index": writer.picture(np.full((3, 2, 4), 255))}
    scene = read_square(tmp_path, writer, extensions=extensions, alphaMode="BLEND")
    material = scene.materials[0]
    base, rough = (
        scene.images[i] for i in (material.base_color_map, material.metallic_roughness_map)
    )
    linear = ((base[0, 0, :3] / 255 + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(linear, plain.base_color, atol=0.01)
    assert base[0, 0, 3] / 255 == pytest.approx(0.25, abs=0.01)
    assert rough[0, 0, 1:3] / 255 == pytest.approx([0.25, plain.metallic], abs=0.01)


def test_glossy_textures_of_two_sizes_get_common_size():
    white, factor = np.full((2, 4, 4), 255, np.uint8), np.ones(4)
    base, rough = convert_gloss_pictures(
        (white, factor), (np.full((8, 2, 4), 255, np.uint8), factor)
    )
    assert base.shape == rough.shape == (8, 4, 4)


@pytest.mark.parametrize(
    ("color", "through", "alpha"), [(1, 1, 0.1), (0.5, 1, 0.55), (1, 0.5, 0.55)]
)
def test_gltf_glass_covers_what_it_does_not_transmit(tmp_path, color, through, alpha):
    glass = {"KHR_materials_transmission": {"transmissionFactor": through}}
    shine = {"baseColorFactor": [color] * 3 + [1]}
    scene = read_square(tmp_path, pbrMetallicRoughness=shine, extensions=glass)
    material = scene.materials[0]
    assert material.is_blended and material.base_alpha == pytest.approx(alpha)
    assert "thin panes" in scene.notes[0]


def test_gltf_maps_keep_their_own_uv_placement(tmp_path):
    writer = GltfWriter()
    number = writer.picture([[[255, 0, 0]]])
    moved = {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 3]}}
    scene = read_square(
        tmp_path,
        writer,
        pbrMetallicRoughness={"baseColorTexture": {"index": number, "extensions": moved}},
        emissiveTexture={"index": number, "texCoord": 1},
    )
    color, _, emission, *_ = scene.materials[0].map_places
    assert (color.matrix, color.offset) == (((2, 0), (0, 3)), (0.5, 0))
    assert (color.coordinates, emission.coordinates) == (0, 1)
    mesh = scene.meshes[0]
    np.testing.assert_array_equal(mesh.uvs, SQUARE_UVS[mesh.sources])
    np.testing.assert_array_equal(mesh.more_uvs, SQUARE_UVS[mesh.sources] / 2)


def test_gltf_maps_with_same_placement_need_no_places(tmp_path):
    writer = GltfWriter()
    info = {"index": writer.picture([[[255, 0, 0]]]), "texCoord": 1}
    shine = {"baseColorTexture": info}
    scene = read_square(tmp_path, writer, pbrMetallicRoughness=shine, emissiveTexture=info)
    assert scene.materials[0].map_places is None and scene.meshes[0].more_uvs is None
    mesh = scene.meshes[0]
    np.testing.assert_array_equal(mesh.uvs, SQUARE_UVS[mesh.sources] / 2)


def test_gltf_material_losses_are_noted_once_with_count(tmp_path):
    writer = square_scene()
    for _ in range(3):
        writer.add("materials", extensions={"KHR_materials_clearcoat": {}})
    writer.add("materials", extensions={"KHR_materials_sheen": {}})
    used = ["KHR_materials_clearcoat", "KHR_materials_sheen", "VENDOR_fog", "KHR_xmp_json_ld"]
    writer.json["extensionsUsed"] = used
    writer.json["scenes"].append({"nodes": []})
    notes = read_scene(writer.write(tmp_path / "a.glb")).notes
    assert [note.split(": ", 1)[1] for note in notes] == [
        "Of materials these are left out: clearcoat (3 materials), sheen (1 material).",
        "These extensions of the file are not read: VENDOR_fog.",
        "Only the default one of its 2 scenes is read.",
    ]


def test_gltf_unknown_required_extension_is_rejected(tmp_path):
    writer = square_scene()
    writer.json["extensionsRequired"] = ["VENDOR_fog"]
    with pytest.raises(InputError, match=r"a\.glb.*VENDOR_fog"):
        read_scene(writer.write(tmp_path / "a.glb"))


# Points and lines

CORNERS = np.float32([[0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0]])


@pytest.mark.parametrize(
    ("mode", "triangles"),
    [(0, 4 * 32), (1, 2 * 8), (2, 4 * 8), (3, 3 * 8)],
    ids=["points", "lines", "loop", "strip"],
)
def test_gltf_points_and_lines_become_thin_geometry(tmp_path, mode, triangles):
    writer = GltfWriter()
    tints = np.eye(4, 3, dtype=np.float32)
    writer.node(mesh=writer.mesh(CORNERS, None, {"COLOR_0": tints}, mode=mode))
    scene = read_scene(writer.write(tmp_path / "a.glb"))
    mesh = scene.meshes[0]
    assert len(mesh.triangles) == triangles
    assert (np.linalg.norm(mesh.positions_m - CORNERS[mesh.sources], axis=1) < 5 / 500).all()
    np.testing.assert_array_equal(mesh.colors, tints[mesh.sources])
    assert "thin" in scene.notes[0]


def test_gltf_many_points_and_lines_are_limited(tmp_path):
    """A colored helix is drawn in every mode; no triangle may lie away from it."""
    count, writer = 240_001, GltfWriter()
    turns = np.linspace(0, 200 * np.pi, count)
    helix = np.stack([np.cos(turns), np.sin(turns), turns / 700], axis=1).astype(np.float32)
    tints = np.random.default_rng(5).random((count, 3), np.float32)
    for mode in range(4):
        writer.node(mesh=writer.mesh(helix, None, {"COLOR_0": tints}, mode=mode))
    scene = read_scene(writer.write(tmp_path / "a.glb"))
    assert len(scene.meshes) == 4
    assert sum(len(mesh.triangles) for mesh in scene.meshes) < 1.01 * 4 * POINTS_MOST
    for mesh in scene.meshes:
        distances_m = np.linalg.norm(mesh.positions_m - helix[mesh.sources], axis=1)
        assert distances_m.max() < 2 * np.linalg.norm(np.ptp(helix, axis=0)) / 600
        np.testing.assert_array_equal(mesh.colors, tints[mesh.sources])
        np.testing.assert_allclose(np.ptp(mesh.positions_m, axis=0), (2, 2, 0.9), atol=0.03)
    assert "some are left out" in scene.notes[0]


def test_gltf_line_with_one_end_is_ignored(tmp_path):
    writer = square_scene()
    writer.node(mesh=writer.mesh(CORNERS[:1], None, mode=2))
    assert len(read_scene(writer.write(tmp_path / "a.glb")).instances) == 1


def test_gltf_transmission_texture_sets_alpha_per_pixel(tmp_path):
    writer = GltfWriter()
    number = writer.picture([[[255, 0, 0], [0, 0, 0]]])
    glass = {"transmissionFactor": 1, "transmissionTexture": {"index": number}}
    scene = read_square(tmp_path, writer, extensions={"KHR_materials_transmission": glass})
    material = scene.materials[0]
    alpha = scene.images[material.base_color_map][0, :, 3]
    assert material.is_blended and alpha.tolist() == [26, 255]  # a tenth of 255, and all


def test_gltf_transmission_texture_with_other_uvs_uses_its_mean(tmp_path):
    writer = GltfWriter()
    number = writer.picture([[[255, 0, 0], [0, 0, 0]]])
    info = {"index": number, "texCoord": 1}
    glass = {"transmissionFactor": 1, "transmissionTexture": info}
    shine = {"baseColorTexture": {"index": number}}
    extensions = {"KHR_materials_transmission": glass}
    scene = read_square(tmp_path, writer, pbrMetallicRoughness=shine, extensions=extensions)
    assert scene.materials[0].base_alpha == pytest.approx(1 - 0.9 / 2)
    assert any("by their mean (1)" in note for note in scene.notes)


@pytest.mark.parametrize(
    ("wrap", "expected"),
    [
        (10497, [(1, 0), (0, 1), (1, 0), (0, 1)]),
        (33071, [(1, 0), (1, 0), (1, 0), (0, 1)]),
        (33648, [(0, 1), (1, 0), (1, 0), (0, 1)]),
    ],
)
def test_gltf_texture_wraps_as_its_sampler_says(tmp_path, session_context, wrap, expected):
    """A red and a green half cover u from -1 to 1, a pixel in the middle of each half."""
    writer = GltfWriter()
    writer.add("samplers", wrapS=wrap, wrapT=33071)
    halves = np.repeat([[[255, 0, 0], [0, 255, 0]]], 16, axis=1)
    number = writer.picture(halves)
    writer.json["textures"][number]["sampler"] = 0
    unlit = {"KHR_materials_unlit": {}}
    shine = {"baseColorTexture": {"index": number}}
    material = writer.add("materials", pbrMetallicRoughness=shine, extensions=unlit)
    uvs = (SQUARE_UVS * [2, 1] - [1, 0]).astype(np.float32)
    writer.node(mesh=writer.mesh(attributes={"TEXCOORD_0": uvs}, material=material))
    scene = read_scene(writer.write(tmp_path / "a.glb"))
    raster = SceneRaster(session_context)
    raster.load(scene)
    raster.place(1)
    view = pose_looking_at((0.5, 0.5, 1), (0.5, 0.5, 0)).world_to_camera
    color = new_texture(session_context, (4, 4), 4)
    raster.draw(
        SceneView(
            world_to_camera=view, size=(4, 4), focal_px=4.0, focus_m=np.inf, near_m=0.1, far_m=100.0
        ),
        color,
    )
    found = download(color)[2, :, :2]
    color.release()
    raster.release()
    np.testing.assert_allclose(found, expected, atol=0.01)
