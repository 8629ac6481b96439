"""Test the add-on's packets and its depth buffer conversion, with a fake of Blender's module."""

import importlib.util
import sys
import time
import tomllib
import zipfile
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import heatlens
from heatlens.core.base.paths import data_dir
from heatlens.fronts.commands.main import main
from heatlens.media.live.stream.protocol import CreateImage, PacketStream, ReadFile, parse_message
from heatlens.media.live.stream.received_plate import LENS_IMAGE


def fake_bpy_modules() -> dict[str, ModuleType]:
    """Return fake modules `bpy` and `bpy.props` with what the add-on needs to be imported."""
    bpy, props = ModuleType("bpy"), ModuleType("bpy.props")
    kinds = ("Operator", "Panel", "PropertyGroup", "AddonPreferences", "Collection")
    bpy.types = SimpleNamespace(**{kind: type(kind, (), {}) for kind in kinds})
    for name in ("Bool", "Int", "Pointer", "String"):
        setattr(props, f"{name}Property", lambda **words: None)
    bpy.props = props
    return {"bpy": bpy, "bpy.props": props}


@pytest.fixture(scope="module")
def addon():
    path = data_dir("assets") / "blender" / "heatlens_addon.py"
    spec = importlib.util.spec_from_file_location(
        "heatlens_addon", path, submodule_search_locations=[str(path.parent)]
    )
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        for name, part in fake_bpy_modules().items():
            patch.setitem(sys.modules, name, part)
        patch.setitem(sys.modules, "heatlens_addon", module)
        spec.loader.exec_module(module)
        yield module
    sys.modules.pop("heatlens_addon.program")


def messages(data: bytes) -> list:
    """Return the messages that heatlens decodes from the bytes of a connection."""
    stream, received = PacketStream(), []
    while data:
        count = stream.expected_bytes
        packet, data = stream.feed(data[:count]), data[count:]
        if packet is not None:
            received.append(parse_message(packet))
    assert stream.buffered_bytes == 0
    return received


def test_addon_picture_packets_decode_to_same_pixels(addon, rng):
    pixels = rng.random((5, 7, 4), np.float32)
    create_message, update_message = messages(
        addon.created("Blender", 7, 5, "RGBZ") + addon.updated("Blender", pixels, "RGBZ")
    )
    assert create_message == CreateImage("Blender", 7, 5, ("R", "G", "B", "Z"))
    assert (update_message.name, update_message.x, update_message.y) == ("Blender", 0, 0)
    for index, channel in enumerate("RGBZ"):
        np.testing.assert_array_equal(update_message.tiles[channel], pixels[..., index])


def test_addon_lens_packets_decode_to_lens_image(addon):
    sample = {"focal_length_mm": 35, "sensor_width_mm": 24, "f_stop": 2, "focus_distance_m": 4}
    create_message, update_message = messages(addon.lens_packets(sample))
    assert (create_message.name, create_message.width, create_message.height) == (LENS_IMAGE, 1, 1)
    assert {name: float(tile[0, 0]) for name, tile in update_message.tiles.items()} == sample


@pytest.mark.parametrize("is_first", [True, False])
def test_addon_request_decodes_to_read_file(addon, is_first):
    assert messages(addon.asked("/tmp/a b.exr", is_first)) == [ReadFile("/tmp/a b.exr")]


@given(st.floats(0.01, 1.0), st.floats(10.0, 1e4), st.floats(0.0, 0.999))
def test_planar_depth_converts_depth_buffer_to_meters(addon, near, far, share):
    """The depth buffer values come from the OpenGL projection of known distances."""
    distance = near + share * (far - near)
    a, b = -(far + near) / (far - near), -2 * far * near / (far - near)
    projection = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, a, b], [0, 0, -1, 0]]
    depth = ((a * -distance + b) / distance + 1) / 2
    depths = addon.planar_depth([[depth, 1.0]], projection)
    assert depths[0, 0] == pytest.approx(distance, rel=1e-6 * far / near)
    assert depths[0, 1] == addon.SKY_M


@pytest.mark.parametrize(
    ("fit", "size", "sensor"),
    [
        ("HORIZONTAL", (1920, 1080), (36.0, 20.25)),
        ("AUTO", (1920, 1080), (36.0, 20.25)),
        ("AUTO", (1080, 1920), (20.25, 36.0)),
        ("VERTICAL", (1920, 1080), (24 * 16 / 9, 24.0)),
    ],
)
def test_sensor_mm_is_visible_part_of_sensor(addon, fit, size, sensor):
    data = SimpleNamespace(sensor_fit=fit, sensor_width=36.0, sensor_height=24.0)
    across, down = size
    render = SimpleNamespace(
        resolution_x=across, resolution_y=down, pixel_aspect_x=1.0, pixel_aspect_y=1.0
    )
    assert addon.sensor_mm(data, render) == pytest.approx(sensor)


def test_addon_build_writes_same_extension_each_time(tmp_path, capsys):
    files = [tmp_path / "a.zip", tmp_path / "b.zip"]
    assert [main(["addon", "build", "-o", str(file)]) for file in files] == [0, 0]
    assert files[0].read_bytes() == files[1].read_bytes()
    with zipfile.ZipFile(files[0]) as archive:
        assert set(archive.namelist()) == {
            "__init__.py",
            "program.py",
            "blender_manifest.toml",
        }
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        compile(archive.read("__init__.py"), "__init__.py", "exec")
    assert manifest["version"] == heatlens.__version__ and manifest["license"] == ["SPDX:MIT"]
    texts = [manifest["tagline"], *manifest["permissions"].values()]
    assert all(len(text) <= 64 and text[-1].isalnum() for text in texts)  # Blender's rule


def test_addon_build_refuses_other_names(tmp_path, capsys):
    assert main(["addon", "build", "-o", str(tmp_path / "a.py")]) == 2
    assert ".zip" in capsys.readouterr().err


@pytest.fixture
def preferences(addon, monkeypatch):
    """Return preferences of the add-on as Blender would hold them."""
    preferences = SimpleNamespace(command="", package="heatlens[desk]")
    addons = {"heatlens_addon": SimpleNamespace(preferences=preferences)}
    context = SimpleNamespace(preferences=SimpleNamespace(addons=addons))
    monkeypatch.setattr(addon.bpy, "context", context, raising=False)
    return preferences


def test_command_takes_program_from_named_folder(addon, preferences, tmp_path, monkeypatch):
    """The preferences name a command, an environment, or the folder without Python."""
    command = addon.program.command
    monkeypatch.delenv("HEATLENS", raising=False)
    assert command("info") == ["heatlens", "info"]
    preferences.command = "python3 -m heatlens"
    assert command("info") == ["python3", "-m", "heatlens", "info"]
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "heatlens").touch()
    preferences.command = str(tmp_path)
    assert command("info") == [str(tmp_path / "bin" / "heatlens"), "info"]


def test_installation_that_pip_refuses_keeps_preferences_and_tells_why(
    addon, preferences, tmp_path
):
    missing = tmp_path / "heatlens-9-py3-none-any.whl"
    installation = addon.program.Installation()
    installation.begin(tmp_path / "environment", str(missing))
    while installation.is_busy:
        installation.poll()
        time.sleep(0.02)
    assert missing.name in installation.message and preferences.command == ""


def test_install_refuses_while_blender_stays_offline(addon, preferences, monkeypatch):
    monkeypatch.setattr(addon.bpy, "app", SimpleNamespace(online_access=False), raising=False)
    operator, said = addon.HEATLENS_OT_install(), []
    operator.report = lambda kinds, text: said.append((kinds, text))
    assert operator.execute(None) == {"CANCELLED"}
    assert said == [({"ERROR"}, addon.program.OFFLINE)]
