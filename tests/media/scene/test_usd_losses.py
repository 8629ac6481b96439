"""Contents of a USD stage that are not read are noted: each kind once, with its count."""

import pytest

from heatlens.media.scene.usd.read import usd_scene

HEAD = '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Y"\n)\ndef Sphere "ball" {}\n'
MATERIAL = """
def Material "paint"
{
    token outputs:surface.connect = </paint/surface.outputs:surface>
    def Shader "surface"
    {
        uniform token info:id = "%s"
        %s
        token outputs:surface
    }
    def Shader "picture"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @gone.png@
        token inputs:wrapS = "%s"
        float4 inputs:scale = (1, 1, 1, 1)
        float2 inputs:st.connect = </paint/place.outputs:result>
        float3 outputs:rgb
        float outputs:r
    }
    def Shader "place"
    {
        uniform token info:id = "%s"
        float2 outputs:result
    }
}
def Cube "painted" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </paint>
}
def Cube "too" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </paint>
}
"""


def painted_cubes(words, kind="UsdPreviewSurface", wrap="repeat", place="UsdPrimvarReader_float2"):
    return MATERIAL % (kind, words, wrap, place)


def cube(words):
    return f'def Cube "a"\n{{\n    {words}\n}}\n'


COLOR = "color3f inputs:diffuseColor.connect = </paint/picture.outputs:rgb>"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('def SphereLight "a" {}\ndef SphereLight "b" {}', ["used instead: 2 SphereLight."]),
        ('def Skeleton "a" {}', ["not read: 1 Skeleton."]),
        ('def Volume "a" {}', ["not read: 1 Volume."]),
        ('def NewThing "a" {}', ["of unknown kinds: 1 NewThing."]),
        ('def "a" (references = @gone.usda@) {}', ["that are missing: 'gone.usda'."]),
        (cube('token visibility.timeSamples = {1: "invisible", 9: "inherited"}'),
         ["appear or vanish over time", "(1)"]),
        (cube('double size.timeSamples = {1: 1, 9: 2}'), ["changes over time", "(1)"]),
        (cube('uniform token purpose = "proxy"'), ["proxies", "(1)"]),
        (cube('float[] primvars:displayOpacity = [0.5]'), ["opacity of objects", "(1)"]),
        (cube('float[] primvars:displayOpacity = [1]'), []),
        (painted_cubes("float inputs:roughness = 0.2\nfloat inputs:ior = 1.5"), []),
        (painted_cubes("float inputs:ior = 1.3"), ["is ignored: ior (1)."]),
        (painted_cubes("float inputs:clearcoat = 1"), ["is ignored: clearcoat (1)."]),
        (painted_cubes("float inputs:mine = 1"), ["is ignored: mine (1)."]),
        (painted_cubes("float inputs:roughness.connect = </paint/picture.outputs:r>"),
         ["Pictures of this", "roughness (1)."]),
        (painted_cubes("normal3f inputs:normal.connect = </paint/picture.outputs:rgb>"),
         ["is ignored: normal (1)."]),
        (painted_cubes(COLOR, wrap="clamp"), ["of pictures is ignored: wrapS (1)."]),
        (painted_cubes(COLOR, place="UsdTransform2d"), ["transforms of pictures are ignored (1)."]),
        (painted_cubes("", kind="ND_standard"), ["as far as they match it: ND_standard (1)."]),
        ("", []),
    ],
)  # fmt: skip
def test_usd_losses_are_noted_once_with_count(tmp_path, text, words):
    path = tmp_path / "a.usda"
    path.write_text(HEAD + text)
    notes = [note.removeprefix(f"{path}: ") for note in usd_scene(str(path)).notes]
    loss_notes = [note for note in notes if "it is ignored" not in note]  # gone.png
    if words:
        assert len(loss_notes) == 1, loss_notes
        assert all(part in loss_notes[0] for part in words), loss_notes
    else:
        assert not loss_notes
