"""USD geometry that is converted to triangles: shapes, subdivision, instancers, curves."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.usd import subdivision
from heatlens.media.scene.usd.read import usd_scene


def stage_at(path):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    return stage


def read(stage):
    stage.Save()
    return usd_scene(stage.GetRootLayer().realPath)


@pytest.mark.parametrize(
    ("kind", "attributes", "size"),
    [
        ("Sphere", {"radius": 2.0}, (4, 4, 4)),
        ("Cube", {"size": 3.0}, (3, 3, 3)),
        ("Cylinder", {"radius": 1.0, "height": 5.0, "axis": "X"}, (5, 2, 2)),
        ("Cone", {"radius": 1.0, "height": 5.0, "axis": "Y"}, (2, 5, 2)),
        ("Capsule", {"radius": 1.0, "height": 5.0}, (2, 2, 7)),
        ("Plane", {"width": 4.0, "length": 6.0}, (4, 6, 0)),
        ("Plane", {"width": 4.0, "length": 6.0, "axis": "X"}, (0, 6, 4)),
        ("Plane", {"width": 4.0, "length": 6.0, "axis": "Y"}, (4, 0, 6)),
        ("Cylinder_1", {"radiusTop": 1.0, "radiusBottom": 2.0, "height": 5.0}, (4, 4, 5)),
    ],
)
def test_usd_shapes_have_size_and_motion_of_file(tmp_path, kind, attributes, size):
    stage = stage_at(tmp_path / "a.usda")
    prim = stage.DefinePrim("/thing", kind)
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    move = UsdGeom.Xformable(prim).AddTranslateOp()
    for frame in (1, 11):
        move.Set(Gf.Vec3d(frame, 0, 0), frame)
    scene = read(stage)
    low, high = bounds_m(scene, 1)
    np.testing.assert_allclose(high - low, size, atol=1e-5)
    assert bounds_m(scene, 6).mean(axis=0) == pytest.approx((6, 0, 0), abs=1e-5)


def test_usd_sphere_of_negative_radius_is_rejected_of_zero_is_empty(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    UsdGeom.Sphere.Define(stage, "/ball").CreateRadiusAttr(-1.0)
    with pytest.raises(InputError, match=r"/ball: its radius is -1"):
        read(stage)
    UsdGeom.Sphere(stage.GetPrimAtPath("/ball")).GetRadiusAttr().Set(0.0)
    with pytest.raises(InputError, match="no surfaces to look at"):
        read(stage)


def box(stage, path="/box", scheme="catmullClark"):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    faces = "0132 4675 0451 2376 0264 1573"
    mesh.CreateFaceVertexIndicesAttr([int(digit) for digit in faces.replace(" ", "")])
    if scheme:
        mesh.CreateSubdivisionSchemeAttr(scheme)
    return mesh


def test_usd_subdivision_is_smooth_except_at_creases(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    box(stage)
    scene = read(stage)
    assert scene.triangle_count == 6 * 16 * 2 and not scene.notes
    radii = np.linalg.norm(scene.meshes[0].positions_m, axis=1)
    assert 0.83 < radii.min() < radii.max() < 1.0
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/box"))
    mesh.CreateCreaseIndicesAttr([0, 1, 3, 2, 0])  # round the face at x = -1
    mesh.CreateCreaseLengthsAttr([5])
    mesh.CreateCreaseSharpnessesAttr([10.0])
    (creased_mesh,) = read(stage).meshes
    flat = creased_mesh.positions_m[:, 0] < -1 + 1e-6
    assert np.ptp(creased_mesh.positions_m[flat][:, 1]) > 1.5
    assert ((creased_mesh.normals[flat] == (-1, 0, 0)).all(axis=1)).any()


@pytest.mark.parametrize(
    ("scheme", "normals", "count"),
    [("none", False, 12), ("bilinear", False, 12), ("", False, 192), ("", True, 12)],
)
def test_usd_scheme_and_normals_decide_on_subdivision(tmp_path, scheme, normals, count):
    stage = stage_at(tmp_path / "a.usda")
    mesh = box(stage, scheme=scheme)
    if normals:
        mesh.CreateNormalsAttr([(0, 1, 0)] * 24)
        mesh.SetNormalsInterpolation("faceVarying")
    assert read(stage).triangle_count == count


def test_usd_subdivision_keeps_holes_uvs_and_face_colors(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    mesh = box(stage)
    mesh.CreateHoleIndicesAttr([5])
    uvs = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray)
    uvs.SetInterpolation("faceVarying")
    uvs.Set([(0, 0), (1, 0), (1, 1), (0, 1)] * 6)
    mesh.CreateDisplayColorPrimvar("uniform").Set([(i / 8, 0, 0) for i in range(6)])
    (found,) = read(stage).meshes
    assert len(found.triangles) == 5 * 16 * 2
    assert np.unique(found.uvs * 4).tolist() == [0, 1, 2, 3, 4]
    assert np.unique(found.colors[found.triangles][..., 0] * 8).round(5).tolist() == [0, 1, 2, 3, 4]


def test_usd_too_large_mesh_is_subdivided_less_with_a_note(tmp_path, monkeypatch):
    monkeypatch.setattr(subdivision, "_QUADS_OF_MESH_MOST", 30)
    stage = stage_at(tmp_path / "a.usda")
    box(stage)
    scene = read(stage)
    assert scene.triangle_count == 48 and "once instead of twice" in scene.notes[0]
    monkeypatch.setattr(subdivision, "_QUADS_OF_MESH_MOST", 20)
    scene = read(stage)
    assert scene.triangle_count == 12 and "drawn as their cages" in scene.notes[0]


def instancer_of(stage, *kinds):
    found = UsdGeom.PointInstancer.Define(stage, "/many")
    for kind in kinds:
        path = f"/many/prototypes/{kind}"
        prim = stage.DefinePrim(path, kind)
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(0, 10, 0))
        found.GetPrototypesRel().AddTarget(path)
    return found


def test_usd_point_instancer_draws_prototypes_only_at_its_points(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    many = instancer_of(stage, "Cube", "Sphere")
    many.CreateProtoIndicesAttr([0, 1, 0, 1])
    many.CreatePositionsAttr([(0, 0, 0), (5, 0, 0), (10, 0, 0), (99, 0, 0)])
    many.CreateScalesAttr([(1, 1, 1), (1, 1, 1), (2, 2, 2), (1, 1, 1)])
    many.CreateInvisibleIdsAttr([3])
    UsdGeom.Xformable(many).AddTranslateOp().Set(Gf.Vec3d(0, 0, 3))
    scene = read(stage)
    assert [instance.name for instance in scene.instances] == ["Cube", "Cube", "Sphere"]
    places = scene.transforms_at(1)[:, :3, 3].tolist()
    assert places == [[0, 10, 3], [10, 20, 3], [5, 10, 3]] and len(scene.meshes) == 2
    low, high = bounds_m(scene, 1)
    assert low == pytest.approx((-1, 9, 1)) and high == pytest.approx((12, 22, 5))


def test_usd_point_instancer_interpolates_positions(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    many = instancer_of(stage, "Cube")
    many.CreateProtoIndicesAttr([0, 0])
    for frame in (1, 5):
        many.CreatePositionsAttr().Set([(0, 0, 0), (frame, 0, 0)], frame)
    scene = read(stage)
    assert scene.frames == FrameRange(1, 5)
    assert scene.transforms_at(2.5)[:, 0, 3] == pytest.approx([0, 2.5])


def test_usd_inconsistent_point_instancer_is_left_out_with_a_note(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    UsdGeom.Cube.Define(stage, "/other")
    many = instancer_of(stage, "Cube")
    many.CreateProtoIndicesAttr([0, 0, 0])
    many.CreatePositionsAttr([(0, 0, 0)])
    scene = read(stage)
    assert len(scene.instances) == 1 and "inconsistent data" in scene.notes[0]


@pytest.mark.parametrize(
    ("kind", "wrap", "basis", "reach"),
    [
        ("linear", "nonperiodic", "bezier", (0, 3)),
        ("cubic", "nonperiodic", "bezier", (0, 3)),
        ("cubic", "nonperiodic", "catmullRom", (1, 2)),
        ("cubic", "nonperiodic", "bspline", (1, 2)),
        ("cubic", "pinned", "catmullRom", (0, 3)),
    ],
)
def test_usd_curves_are_tubes_from_end_to_end(tmp_path, kind, wrap, basis, reach):
    stage = stage_at(tmp_path / "a.usda")
    curves = UsdGeom.BasisCurves.Define(stage, "/hair")
    curves.CreatePointsAttr([(i, 0, z) for z in (0, 5) for i in range(4)])
    curves.CreateCurveVertexCountsAttr([4, 4])
    curves.CreateTypeAttr(kind)
    curves.CreateWrapAttr(wrap)
    curves.CreateBasisAttr(basis)
    curves.CreateWidthsAttr([0.2, 0.4])
    curves.CreateDisplayColorPrimvar("uniform").Set([(1, 0, 0), (0, 1, 0)])
    scene = read(stage)
    low, high = bounds_m(scene, 1)
    assert (low[0], high[0]) == pytest.approx(reach, abs=1e-5)
    assert (low[2], high[2]) == pytest.approx((-0.1, 5.2), abs=0.03)  # of six sides
    (mesh,) = scene.meshes
    assert (mesh.colors[mesh.positions_m[:, 2] > 3] == (0, 1, 0)).all()


def test_usd_points_are_drawn_and_nurbs_patch_is_noted(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    points = UsdGeom.Points.Define(stage, "/cloud")
    points.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (2, 0, 0)])
    points.CreateWidthsAttr([0.2])
    UsdGeom.NurbsPatch.Define(stage, "/patch")
    scene = read(stage)
    assert len(scene.meshes[0].triangles) == 96
    assert any("Not drawn, of kinds that are not read: 1 NurbsPatch" in n for n in scene.notes)


def test_usd_missing_texture_is_ignored_with_a_note(tmp_path):
    (tmp_path / "a.usda").write_text(
        """#usda 1.0
def Sphere "ball" (prepend apiSchemas = ["MaterialBindingAPI"])
{
 rel material:binding = </m>
}
def Material "m"
{
 token outputs:surface.connect = </m/s.outputs:surface>
 def Shader "s"
 {
  uniform token info:id = "UsdPreviewSurface"
  color3f inputs:diffuseColor.connect = </m/t.outputs:rgb>
  token outputs:surface
 }
 def Shader "t"
 {
  uniform token info:id = "UsdUVTexture"
  asset inputs:file = @gone.png@
  float3 outputs:rgb
 }
}
"""
    )
    scene = usd_scene(str(tmp_path / "a.usda"))
    assert not scene.images and any("gone.png" in n and "it is ignored" in n for n in scene.notes)


def test_first_shot_takes_animated_lens_of_usd_camera(tmp_path):
    stage = stage_at(tmp_path / "a.usda")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.Cube.Define(stage, "/box")
    camera = UsdGeom.Camera.Define(stage, "/cam")
    camera.CreateHorizontalApertureAttr(36)
    camera.CreateFStopAttr(2.0)
    for frame, focal_mm, focus_cm in ((101, 35, 500), (126, 50, 700)):
        camera.CreateFocalLengthAttr().Set(focal_mm, frame)
        camera.CreateFocusDistanceAttr().Set(focus_cm, frame)
    stage.Save()
    first = first_shot(str(tmp_path / "a.usda"))
    assert first.shot.frames == FrameRange(101, 126) and not first.assumed
    for frame, focal_mm, focus_m in ((101, 35, 5), (126, 50, 7)):
        lens = first.shot.lens_at(frame)
        found = (lens.focal_length_mm, lens.f_stop, lens.focus_distance_m)
        assert found == pytest.approx((focal_mm, 2, focus_m))
    middle = first.shot.lens_at(113.5)
    assert (middle.focal_length_mm, middle.focus_distance_m) == pytest.approx((42.5, 6), rel=1e-3)
    given = first_shot(str(tmp_path / "a.usda"), given_fields={"focal_length_mm": 85.0})
    assert given.shot.lens_at(126).focal_length_mm == 85
    assert given.sources["f_stop"] == "camera cam of the scene"


@pytest.mark.parametrize(
    ("f_stop", "focus_m", "assumed"),
    [(0.0, 0.0, {"f_stop", "focus_distance_m"}), (2.0, 0.01, {"focus_distance_m"})],
)
def test_first_shot_assumes_impossible_lens_values_of_usd_camera(
    tmp_path, f_stop, focus_m, assumed
):
    stage = stage_at(tmp_path / "a.usda")
    UsdGeom.Cube.Define(stage, "/box")
    camera = UsdGeom.Camera.Define(stage, "/cam")
    camera.CreateFocalLengthAttr(0.5)
    camera.CreateHorizontalApertureAttr(0.36)
    camera.CreateFStopAttr(f_stop)
    camera.CreateFocusDistanceAttr(focus_m)
    stage.Save()
    first = first_shot(str(tmp_path / "a.usda"))
    assert first.assumed == assumed
    assert any("not possible for a lens" in n for n in first.scene.notes) == (focus_m > 0)
