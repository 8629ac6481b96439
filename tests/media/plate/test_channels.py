"""Test which channels are chosen for color and depth in the layouts that renderers write."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.plate.header.channel_choice import choose_color, choose_depth
from heatlens.media.plate.header.channels import views_of

FILE = Path("shot.exr")


def header(*names, part="", sampling=1):
    channels = [SimpleNamespace(name=name, xSampling=1, ySampling=1) for name in names]
    for channel in channels:
        if channel.name in ("RY", "BY"):
            channel.xSampling = channel.ySampling = sampling
    return {"name": part, "channels": channels, "type": "Storage.scanlineimage"}


def chosen_channels(*headers, layer=None, depth=None, coc=False):
    """Return full names of red, alpha and depth."""
    color = choose_color(FILE, headers, layer)
    alpha = color.alpha.full_name if color.alpha else None
    return color.rgb[0].full_name, alpha, choose_depth(FILE, headers, depth, color, coc).full_name


BLENDER = [f"ViewLayer.{n}" for n in ("Combined.R", "Combined.G", "Combined.B", "Combined.A")]
BLENDER += [f"ViewLayer.Normal.{axis}" for axis in "XYZ"] + ["ViewLayer.Mist.Z"]
LAYOUTS = [
    ([header("A", "B", "G", "R", "Z")], ("R", "A", "Z")),
    ([header("b", "g", "r", "z")], ("r", None, "z")),
    ([header("red", "green", "blue", "alpha", "depth")], ("red", "alpha", "depth")),
    ([header("R", "G", "B", "depth.Z", "N.X", "N.Y", "N.Z")], ("R", None, "depth.Z")),
    ([header("R", "G", "B", "P.X", "P.Y", "P.Z", "distance")], ("R", None, "distance")),
    ([header("Y", "Z")], ("Y", None, "Z")),
    (
        [header(*BLENDER, "ViewLayer.Depth.Z")],
        ("ViewLayer.Combined.R", "ViewLayer.Combined.A", "ViewLayer.Depth.Z"),
    ),
    (
        [header(*BLENDER, "ViewLayer.Depth.V")],
        ("ViewLayer.Combined.R", "ViewLayer.Combined.A", "ViewLayer.Depth.V"),
    ),
    ([header("zdepth.R", "zdepth.G", "zdepth.B", "R", "G", "B")], ("R", None, "zdepth.R")),
    (
        [
            header("R", "G", "B", part="albedo"),
            header("R", "G", "B", "A", part="beauty"),
            header("Z", part="depth"),
        ],
        ("beauty.R", "beauty.A", "depth.Z"),
    ),
    ([header("C.R", "C.G", "C.B", part="C"), header("Pz", part="Pz")], ("C.R", None, "Pz.Pz")),
    ([header("R", "G", "B", "Z", "right.R", "right.G", "right.B", "right.Z")], ("R", None, "Z")),
    ([header("R", "G", "B", "disparity")], ("R", None, "disparity")),
]


@pytest.mark.parametrize(("headers", "expected"), LAYOUTS)
def test_choose_channels_in_layouts_of_renderers(headers, expected):
    assert chosen_channels(*headers) == expected


def test_choose_depth_prefers_view_of_the_color():
    part_header = header(
        "left.R", "left.G", "left.B", "left.Z", "right.R", "right.G", "right.B", "right.Z"
    )
    assert chosen_channels(part_header) == ("left.R", None, "left.Z")
    assert chosen_channels(part_header, layer="right") == ("right.R", None, "right.Z")


def test_choose_channels_by_full_name_or_layer_in_any_case():
    part_header = header(
        "R", "G", "B", "diffuse.R", "diffuse.G", "diffuse.B", "Z", "fog.V", "Near.Z"
    )
    assert chosen_channels(part_header, layer="Diffuse") == ("diffuse.R", None, "Z")
    assert chosen_channels(part_header, layer="") == ("R", None, "Z")
    assert chosen_channels(part_header, depth="fog.V")[2] == "fog.V"
    assert chosen_channels(part_header, depth="near")[2] == "Near.Z"


def test_choose_depth_takes_circle_of_confusion_only_on_request():
    part_header = header("R", "G", "B", "Z", "coc")
    assert chosen_channels(part_header)[2] == "Z"
    assert chosen_channels(part_header, coc=True)[2] == "coc"


def test_choose_color_notes_guessed_layer():
    part_header = header(*(f"{layer}.{c}" for layer in ("diffuse", "specular") for c in "RGB"))
    color = choose_color(FILE, [part_header], None)
    assert color.layer == "diffuse"
    assert "--color-layer" in color.notes[0] and "specular" in color.notes[0]


@pytest.mark.parametrize(
    ("names", "depth", "words"),
    [
        (["R", "G", "B"], None, r"no depth channel, such as Z.*has: R, G, B.*--depth-channel"),
        (["R", "G", "B", "N.X", "N.Y", "N.Z"], None, "no depth channel"),
        (["R", "G", "B", "Z"], "foo", r"'foo' for --depth-channel; it has: R, G, B, Z"),
        (["Z"], None, "no colour: looked for channels R, G, B"),
    ],
)
def test_choose_channels_error_names_expected_and_existing_channels(names, depth, words):
    with pytest.raises(InputError, match=words) as error:
        chosen_channels(header(*names), depth=depth)
    assert str(error.value).startswith("shot.exr")


def test_choose_color_rejects_missing_layer():
    with pytest.raises(InputError, match=r"'beauty' for --color-layer; it has: \(no name\)"):
        choose_color(FILE, [header("R", "G", "B")], "beauty")


def test_choose_color_rejects_luminance_and_chroma():
    with pytest.raises(InputError, match="chroma"):
        choose_color(FILE, [header("Y", "RY", "BY", "Z", sampling=2)], None)


def stereo_headers(*names, view=True):
    """Return headers of parts with color or depth, each for the eye that its name ends in."""
    headers = []
    for name in names:
        channels = ["Z"] if "depth" in name else ["R", "G", "B"]
        view_entry = {"view": name[-5:].strip("_.")} if view else {}
        headers.append(header(*channels, part=name) | view_entry)
    return headers


EYES = ("rgba_right", "rgba_left", "depth_left", "depth_right")
ONE_PART = header("R", "G", "B", "Z", "right.R", "right.G", "right.B", "right.Z")
BLENDER_STEREO = [
    header(*(f"ViewLayer.{layer}.{c}" for c in names), part=f"ViewLayer.{layer}-{eye}")
    | {"view": eye}
    for layer, names in (("Combined", "RGBA"), ("Depth", "Z"))
    for eye in ("left", "right")
]
STEREO = [
    BLENDER_STEREO,
    stereo_headers(*EYES),
    stereo_headers(*reversed(EYES)),
    stereo_headers(*EYES, view=False),
    stereo_headers("left", "right", "depth_right", "depth_left"),
    stereo_headers("rgba.left", "rgba.right", "depth.left", "depth.right", view=False),
    [ONE_PART | {"multiView": ["left", "right"]}],
    [header(*(f"{e}.{c}" for e in ("left", "right") for c in "RGB"), "z.left.Z", "z.right.Z")],
]


@pytest.mark.parametrize("headers", STEREO)
@pytest.mark.parametrize("eye", [None, "left", "right", "RIGHT"])
def test_choose_depth_takes_depth_of_the_same_eye(headers, eye):
    color = choose_color(FILE, headers, None, eye)
    depth = choose_depth(FILE, headers, None, color, prefers_coc=False)
    assert color.view == depth.view == (eye or "left").lower()
    note = "left and right: left is taken; --eye right takes the other"
    assert any(note in color_note for color_note in color.notes) == (eye is None)


def test_choose_channels_handles_blender_parts_named_after_view():
    color = choose_color(FILE, BLENDER_STEREO, None, "right")
    assert color.layer == "ViewLayer.Combined-right"
    depth = choose_depth(FILE, BLENDER_STEREO, None, color, prefers_coc=False)
    assert depth.full_name == "ViewLayer.Depth-right.Z"


def test_choose_color_layer_of_other_eye_takes_its_own_depth():
    headers = stereo_headers(*EYES)
    assert chosen_channels(*headers, layer="rgba_right")[2] == "depth_right.Z"
    with pytest.raises(InputError, match=r"no RGB layer 'rgba_right'.*rgba_left"):
        choose_color(FILE, headers, "rgba_right", "left")


def test_choose_depth_never_takes_depth_of_other_eye():
    headers = stereo_headers("rgba_left", "rgba_right", "depth_left")
    right = choose_color(FILE, headers, None, "right")
    with pytest.raises(InputError, match="no depth channel of the view right"):
        choose_depth(FILE, headers, None, right, prefers_coc=False)
    shared_depth_headers = [*stereo_headers("rgba_left", "rgba_right"), header("Z", part="depth")]
    assert (
        choose_depth(FILE, shared_depth_headers, None, right, prefers_coc=False).full_name
        == "depth.Z"
    )


def test_choose_color_rejects_missing_view():
    with pytest.raises(InputError, match=r"no view 'centre' for --eye; it has: left, right"):
        choose_color(FILE, stereo_headers(*EYES), None, "centre")
    with pytest.raises(InputError, match="one view, without a name"):
        choose_color(FILE, [header("R", "G", "B")], None, "right")


def test_views_of_single_eye_are_empty():
    headers = [header("R", "G", "B", "Z") | {"view": "left"}]
    assert views_of(headers) == () and choose_color(FILE, headers, None).notes == ()


def test_choose_depth_takes_channel_t_of_mitsuba():
    """Mitsuba's manual calls the layer dd, as no other program does; T alone is ambiguous."""
    names = ("R", "G", "B", "hit.T", "sh_normal.X", "sh_normal.Y", "sh_normal.Z")
    mitsuba = header(*names) | {"generatedBy": "Mitsuba version 3.9.1"}
    assert chosen_channels(mitsuba)[2] == "hit.T"
    assert chosen_channels(header("R", "G", "B", "depth.T"))[2] == "depth.T"
    assert chosen_channels(header("R", "G", "B", "dd.T"))[2] == "dd.T"
    with pytest.raises(InputError, match="no depth channel"):
        chosen_channels(header(*names))
