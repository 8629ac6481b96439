"""An export counts the layers and textures that a USD file refers to among its inputs."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade, UsdUtils

from heatlens.core.base.errors import InputError
from heatlens.media.scene.scene_read import files_of_scene
from heatlens.media.scene.usd.files import named_by_usd
from support.exports import export_shot, refused_export_message
from support.gltf_files import encoded

SHOT_OPTIONS = ("--f-stop=2", "--focus-distance=2.5", "--size=32x18", "--quality=draft")


@pytest.fixture
def scene(tmp_path) -> Path:
    """Return the path of a USD stage with a sublayer and a reference to a textured prop."""
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "map.png").write_bytes(encoded([[[200, 30, 30]]]))
    prop = Usd.Stage.CreateNew(str(folder / "prop.usda"))
    mesh = UsdGeom.Mesh.Define(prop, "/prop")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    picture = UsdShade.Shader.Define(prop, "/prop/picture")
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("./map.png")
    prop.SetDefaultPrim(mesh.GetPrim())
    prop.Save()
    Usd.Stage.CreateNew(str(folder / "light.usda")).Save()
    stage = Usd.Stage.CreateNew(str(folder / "shot.usda"))
    stage.GetRootLayer().subLayerPaths.append("./light.usda")
    stage.DefinePrim("/thing").GetReferences().AddReference("./prop.usda")
    stage.Save()
    return folder / "shot.usda"


def test_usd_files_include_layers_and_textures(scene):
    files = {scene.parent.resolve() / name for name in ("prop.usda", "light.usda", "map.png")}
    assert set(named_by_usd(str(scene))) == files
    found = files_of_scene(scene)
    assert found[0] == scene and set(found[1:]) == files


def test_named_by_usd_lists_missing_files(scene):
    before = set(named_by_usd(str(scene)))
    (scene.parent / "map.png").unlink()
    assert set(named_by_usd(str(scene))) == before
    (scene.parent / "prop.usda").unlink()
    assert set(named_by_usd(str(scene))) == before - {scene.parent.resolve() / "map.png"}


def test_named_by_usd_counts_usdz_package_as_one_file(scene):
    package = scene.with_suffix(".usdz")
    assert UsdUtils.CreateNewUsdzPackage(str(scene), str(package))
    assert named_by_usd(str(package)) == ()
    stage = Usd.Stage.CreateNew(str(scene.parent / "outer.usda"))
    stage.DefinePrim("/thing").GetReferences().AddReference("./shot.usdz")
    stage.Save()
    assert named_by_usd(str(scene.parent / "outer.usda")) == (package.resolve(),)


def test_named_by_usd_leaves_out_web_addresses(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    picture = UsdShade.Shader.Define(stage, "/picture")
    picture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("https://example.org/a.png")
    stage.Save()
    assert named_by_usd(str(tmp_path / "a.usda")) == ()


def test_export_notices_changed_texture_and_does_not_overwrite_it(capsys, scene, tmp_path):
    out, path = tmp_path / "n.exr", scene.parent / "map.png"
    export_shot(capsys, scene, out, *SHOT_OPTIONS)
    assert "1 was finished before" in export_shot(capsys, scene, out, *SHOT_OPTIONS)
    path.write_bytes(encoded([[[200, 20, 20], [20, 20, 200]]]))
    assert "1 frame written" in export_shot(capsys, scene, out, *SHOT_OPTIONS)
    before = path.read_bytes()
    assert "an input of" in refused_export_message(capsys, scene, path, *SHOT_OPTIONS)
    assert path.read_bytes() == before


@pytest.mark.parametrize("content", [b"#usda 1.0\n(((", b"", b"PXR-USDC" + bytes(80)])
def test_files_of_scene_rejects_file_that_is_no_usd(tmp_path, content):
    path = tmp_path / "a.usda"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.usda"):
        files_of_scene(path)
    with pytest.raises(InputError, match="is not there"):
        files_of_scene(tmp_path / "gone.usda")
