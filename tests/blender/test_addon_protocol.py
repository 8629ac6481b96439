"""What the add-on sends, and how it reads a depth buffer, with a stand-in for Blender's module."""

import importlib.util
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.paths import data_dir
from heatlens.media.live.stream.protocol import CreateImage, PacketStream, ReadFile, message_of
from heatlens.media.live.stream.received_plate import LENS_IMAGE


def stand_in() -> dict[str, ModuleType]:
    """Return a stand-in for bpy with what the add-on needs when it is imported."""
    bpy, props = ModuleType("bpy"), ModuleType("bpy.props")
    kinds = ("Operator", "Panel", "PropertyGroup", "AddonPreferences")
    bpy.types = SimpleNamespace(**{kind: type(kind, (), {}) for kind in kinds})
    for name in ("Bool", "Int", "Pointer", "String"):
        setattr(props, f"{name}Property", lambda **words: None)
    bpy.props = props
    return {"bpy": bpy, "bpy.props": props}


@pytest.fixture(scope="module")
def addon():
    path = data_dir("assets") / "blender" / "heatlens_addon.py"
    spec = importlib.util.spec_from_file_location("heatlens_addon", path)
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        for name, part in stand_in().items():
            patch.setitem(sys.modules, name, part)
        spec.loader.exec_module(module)
    return module


def messages(data: bytes) -> list:
    """Return what heatlens understands of the bytes of a connection."""
    stream, found = PacketStream(), []
    while data:
        count = stream.wanted
        packet, data = stream.feed(data[:count]), data[count:]
        if packet is not None:
            found.append(message_of(packet))
    assert stream.held == 0
    return found


def test_a_picture_arrives_whole(addon, rng):
    pixels = rng.random((5, 7, 4), np.float32)
    begun, sent = messages(
        addon.created("Blender", 7, 5, "RGBZ") + addon.updated("Blender", pixels, "RGBZ")
    )
    assert begun == CreateImage("Blender", 7, 5, ("R", "G", "B", "Z"))
    assert (sent.name, sent.x, sent.y) == ("Blender", 0, 0)
    for index, channel in enumerate("RGBZ"):
        np.testing.assert_array_equal(sent.tiles[channel], pixels[..., index])


def test_the_lens_arrives_under_its_name(addon):
    sample = {"focal_length_mm": 35, "sensor_width_mm": 24, "f_stop": 2, "focus_distance_m": 4}
    begun, sent = messages(addon.lens_packets(sample))
    assert (begun.name, begun.width, begun.height) == (LENS_IMAGE, 1, 1)
    assert {name: float(tile[0, 0]) for name, tile in sent.tiles.items()} == sample


@pytest.mark.parametrize("is_first", [True, False])
def test_a_file_is_asked_for(addon, is_first):
    assert messages(addon.asked("/tmp/a b.exr", is_first)) == [ReadFile("/tmp/a b.exr")]


@given(st.floats(0.01, 1.0), st.floats(10.0, 1e4), st.floats(0.0, 0.999))
def test_depths_of_the_viewport_are_distances(addon, near, far, share):
    """Through the projection of OpenGL, whose last rows take z to clip space."""
    distance = near + share * (far - near)
    a, b = -(far + near) / (far - near), -2 * far * near / (far - near)
    projection = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, a, b], [0, 0, -1, 0]]
    depth = ((a * -distance + b) / distance + 1) / 2
    found = addon.planar_depth([[depth, 1.0]], projection)
    assert found[0, 0] == pytest.approx(distance, rel=1e-6 * far / near)
    assert found[0, 1] == addon.SKY_M


@pytest.mark.parametrize(
    ("fit", "size", "sensor"),
    [
        ("HORIZONTAL", (1920, 1080), (36.0, 20.25)),
        ("AUTO", (1920, 1080), (36.0, 20.25)),
        ("AUTO", (1080, 1920), (20.25, 36.0)),
        ("VERTICAL", (1920, 1080), (24 * 16 / 9, 24.0)),
    ],
)
def test_the_sensor_is_the_part_that_the_picture_shows(addon, fit, size, sensor):
    data = SimpleNamespace(sensor_fit=fit, sensor_width=36.0, sensor_height=24.0)
    across, down = size
    render = SimpleNamespace(
        resolution_x=across, resolution_y=down, pixel_aspect_x=1.0, pixel_aspect_y=1.0
    )
    assert addon.sensor_mm(data, render) == pytest.approx(sensor)
