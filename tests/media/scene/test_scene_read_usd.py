"""USD stages as scenes, written with OpenUSD; each is read in a process of its own."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_read import read_scene
from heatlens.media.scene.usd.read import usd_scene
from support.gltf_files import encoded

BOX = [(0, 0, 0), (100, 0, 0), (100, 200, 0), (0, 200, 0), (50, 300, 0)]


def stage_at(path, up="Y", unit_m=0.01):
    """Return a stage with one mesh: a square and a triangle on top of it."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit_m)
    mesh = UsdGeom.Mesh.Define(stage, "/world/house")
    mesh.CreatePointsAttr(BOX)
    mesh.CreateFaceVertexCountsAttr([4, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 3, 2, 4])
    mesh.CreateSubdivisionSchemeAttr("none")
    return stage, mesh


@pytest.mark.parametrize(("up", "top"), [("Y", (1, 3, 0)), ("Z", (1, 0, 0))])
def test_usd_polygons_are_in_meters_with_y_up(tmp_path, up, top):
    stage, _ = stage_at(tmp_path / "a.usdc", up)
    stage.Save()
    scene = read_scene(tmp_path / "a.usdc")
    assert scene.triangle_count == 3
    assert bounds_m(scene, 1)[1] == pytest.approx(top, abs=1e-6)
    depth = 0 if up == "Y" else -3  # what was y, away from us
    assert bounds_m(scene, 1)[0] == pytest.approx((0, 0, depth), abs=1e-6)


def test_usd_subset_material_with_texture_is_read(tmp_path):
    stage, mesh = stage_at(tmp_path / "a.usda")
    (tmp_path / "pic.png").write_bytes(encoded(np.full((1, 2, 3), 7)))
    uvs = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray)
    uvs.SetInterpolation("vertex")
    uvs.Set([(0, 0), (1, 0), (1, 0.5), (0, 0.5), (0.5, 1)])
    material = UsdShade.Material.Define(stage, "/world/brick")
    surface = UsdShade.Shader.Define(stage, "/world/brick/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.25)
    picture = UsdShade.Shader.Define(stage, "/world/brick/picture")
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("pic.png")
    color = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    color.ConnectToSource(picture.ConnectableAPI(), "rgb")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    subset = binding.CreateMaterialBindSubset("roof", [1])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    mesh.CreateDisplayColorAttr([(0.5, 0, 0)])
    stage.Save()
    scene = usd_scene(tmp_path / "a.usda")
    roof, walls = scene.meshes
    found = scene.materials[roof.material]
    assert (found.name, found.roughness, found.base_color_map) == ("brick", 0.25, 0)
    assert (scene.images[0][..., :3] == 7).all()
    assert scene.materials[walls.material].base_color == (0.5, 0, 0)
    assert (len(roof.triangles), len(walls.triangles)) == (1, 2)
    assert roof.uvs.min(axis=0).tolist() == [0, 0]
    assert roof.uvs.max(axis=0).tolist() == [1, 0.5]


def test_usd_instances_share_a_mesh_and_move(tmp_path):
    stage, _ = stage_at(tmp_path / "a.usda")
    for i in range(3):
        prim = stage.DefinePrim(f"/copies/c{i}", "Xform")
        prim.GetReferences().AddInternalReference("/world")
        prim.SetInstanceable(True)
        move = UsdGeom.Xformable(prim).AddTranslateOp()
        for frame in (11, 21):
            move.Set(Gf.Vec3d(0, 0, 100 * i * (frame - 11)), frame)
    stage.SetTimeCodesPerSecond(25)
    stage.Save()
    scene = read_scene(tmp_path / "a.usda")
    assert (len(scene.meshes), len(scene.instances)) == (2, 4)  # that of /world, and of the copies
    assert (scene.frames, scene.frames_per_second) == (FrameRange(11, 21), 25)
    assert scene.transforms_at(13.5)[:, 2, 3] == pytest.approx([0, 0, 2.5, 5])
    assert scene.transforms_at(99)[:, 2, 3] == pytest.approx([0, 0, 10, 20])


def test_usd_camera_keeps_its_lens_and_pose(tmp_path):
    stage, _ = stage_at(tmp_path / "a.usda", "Z")
    camera = UsdGeom.Camera.Define(stage, "/cam")
    camera.CreateFocalLengthAttr(40)
    camera.CreateHorizontalApertureAttr(24)
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 500))
    stage.Save()
    (found,) = read_scene(tmp_path / "a.usda").cameras
    assert (found.name, found.focal_length_mm, found.sensor_width_mm) == ("cam", 40, 24)
    pose = found.track.pose_at(1)
    assert pose.position_m == pytest.approx((0, 5, 0))
    assert -pose.turn[:, 2] == pytest.approx([0, -1, 0], abs=1e-9)  # it looked down along z


def test_usd_damage_is_reported_with_file_name(tmp_path):
    path = tmp_path / "a.usda"
    for data in (b"", b"#usda 1.0\n(", b"#usda 1.0\n"):
        path.write_bytes(data)
        with pytest.raises(InputError, match=r"a\.usda"):
            read_scene(path)


def test_usd_damaged_mesh_is_left_out_and_noted(tmp_path):
    """The others of the stage are drawn, as in other programs."""
    path = tmp_path / "a.usda"
    head, good = MESH.split("def ")
    bad = good.replace("(1, 0, 0)", "(nan, 0, 0)")
    meshes = [good, *(bad.replace('"M"', f'"B{number}"') for number in range(9))]
    path.write_text(head + "".join(f"def {mesh}" for mesh in meshes))
    scene = usd_scene(str(path))
    assert scene.triangle_count == 1 and len(scene.instances) == 1
    notes = [note for note in scene.notes if "Left out" in note]
    assert str(path) in notes[0] and "/B0" in notes[0]
    assert len(notes) == 9 and notes[-1].endswith("for similar reasons: 1 more objects.")


@pytest.mark.parametrize("corners", [[0, 1, 2, 3, 3, 2, 5], [0, 1], [0, 1, 2, 3, 3, 2, -1]])
def test_usd_inconsistent_polygons_are_rejected(tmp_path, corners):
    stage, mesh = stage_at(tmp_path / "a.usda")
    mesh.GetFaceVertexIndicesAttr().Set(corners)
    stage.Save()
    with pytest.raises(InputError, match=r"a\.usda: /world/house"):
        usd_scene(tmp_path / "a.usda")


@pytest.mark.parametrize("seed", range(4))
def test_usd_binary_with_changed_bytes_gives_scene_or_error(tmp_path, seed):
    stage, _ = stage_at(tmp_path / "a.usdc")
    stage.Save()
    data = bytearray((tmp_path / "a.usdc").read_bytes())
    random = np.random.default_rng(seed)
    for at in random.integers(0, len(data), 6):
        data[at] ^= int(random.integers(1, 256))
    (tmp_path / "b.usdc").write_bytes(data)
    try:
        assert read_scene(tmp_path / "b.usdc").instances
    except HeatlensError as error:
        assert "b.usdc" in str(error)


MESH = """#usda 1.0
( metersPerUnit = 1 )
def Mesh "M"
{
 int[] faceVertexCounts = [3]
 int[] faceVertexIndices = [0, 1, 2]
 point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
 uniform token subdivisionScheme = "none"
}
"""


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("point3f[] points", 'string[] points = ["a", "b", "c"]'),
        ("point3f[] points", 'string points = "long"'),
        ("point3f[] points", "matrix4d points = ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))"),
        ("int[] faceVertexCounts", "float[] faceVertexCounts = [3]"),
        ("int[] faceVertexIndices", 'token[] faceVertexIndices = ["a"]'),
        (" uniform token", ' string[] primvars:displayColor = ["red"]'),
        (" uniform token", ' string primvars:displayColor = "red"'),
        (" uniform token", ' string primvars:st = "red" (interpolation = "vertex")'),
        (" uniform token", ' string primvars:normals = "up" (interpolation = "vertex")'),
    ],
)
def test_usd_values_of_another_kind_are_rejected(tmp_path, name, other):
    """The message names the file; the error is not reported as a fault of heatlens."""
    path = tmp_path / "a.usda"
    path.write_text(MESH)
    assert usd_scene(str(path)).triangle_count == 1
    lines_without = [
        line for line in MESH.splitlines() if not line.strip().startswith(name.strip())
    ]
    path.write_text("\n".join([*lines_without[:-1], other, "}"]))
    with pytest.raises(InputError, match=r"a\.usda") as refusal:
        usd_scene(str(path))
    assert len(str(refusal.value).splitlines()) == 1


def test_usd_scene_camera_in_mm_on_stage_in_meters_is_read_as_mm(tmp_path):
    """A known fault of 3ds Max: by USD the lens would be metres long, which no focus fits."""
    stage, _ = stage_at(tmp_path / "a.usda", unit_m=1.0)
    camera = UsdGeom.Camera.Define(stage, "/world/cam")
    camera.GetFocalLengthAttr().Set(75.0)
    camera.GetHorizontalApertureAttr().Set(36.0)
    camera.GetFocusDistanceAttr().Set(4.0)
    stage.Save()
    scene = read_scene(tmp_path / "a.usda")
    (found,) = scene.cameras
    assert (found.focal_length_mm, found.sensor_width_mm, found.focus_distance_m) == (75, 36, 4)
    assert any("/world/cam" in it and "seems to be in mm" in it for it in scene.notes)
