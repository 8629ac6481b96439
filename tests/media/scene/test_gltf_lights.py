"""Test the lights of glTF files and the exposure that is chosen for them."""

import math

import numpy as np
import pytest

from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.media.scene.scene import Daylight
from heatlens.media.scene.scene_read import read_scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.raster import SceneRaster
from support.gltf_files import GltfWriter, square_scene

BLENDER = "Khronos glTF Blender I/O v5.0.21"
NIGHT = (0.0, 0.0, 0.0)


def lit_square(tmp_path, *lights, generator=BLENDER, place=(0.5, 0.5, 2.0)):
    """Read a square with lights above it."""
    writer = square_scene()
    writer.json["asset"]["generator"] = generator
    for light in lights:
        writer.node(**writer.light(**light), translation=list(place))
    return read_scene(writer.write(tmp_path / "lit.glb"))


def test_blender_lights_are_converted_back_to_watts(tmp_path):
    """The file has 3 W/m^2 of sun and 500 W to all sides, as Blender 5.0 writes them."""
    sun = {"type": "directional", "intensity": 3 * 683}
    lamp = {"type": "point", "intensity": 500 * 683 / (4 * math.pi), "color": [1, 0.5, 0]}
    scene = lit_square(tmp_path, sun, lamp)
    assert scene.daylight.sun == pytest.approx((3, 3, 3))
    watts = 500 / (4 * math.pi)
    assert scene.lights[0].intensity == pytest.approx((watts, watts / 2, 0))
    assert scene.daylight.zenith == scene.daylight.ground == NIGHT
    assert "watts" in scene.notes[0] and "sky is black" in scene.notes[1]


def test_blender_lights_without_unit_stay_unchanged(tmp_path):
    scene = lit_square(tmp_path, {"type": "directional", "intensity": 3})
    assert scene.daylight.sun == (3, 3, 3)
    assert not any("watts" in note for note in scene.notes)


def test_blender_spot_fades_over_cosine(tmp_path):
    half, blend = 0.6, 0.4
    spot = {"outerConeAngle": half, "innerConeAngle": half * (1 - blend)}
    light = lit_square(tmp_path, {"type": "spot", "intensity": 5e4, "spot": spot}).lights[0]
    inner = math.cos(half) + (1 - math.cos(half)) * blend
    assert light.cone_cosines == pytest.approx((inner, math.cos(half)))
    assert light.is_smooth
    plain_spot = lit_square(
        tmp_path, {"type": "spot", "intensity": 5, "spot": spot}, generator=""
    ).lights[0]
    assert plain_spot.cone_cosines == pytest.approx((math.cos(0.36), math.cos(half)))
    assert not plain_spot.is_smooth


@pytest.mark.parametrize("lux", [100.0, 1e5, 2e9])
def test_daylight_in_lux_is_exposed_for_the_image(tmp_path, lux):
    scene = lit_square(tmp_path, {"type": "directional", "intensity": lux}, generator="bevy")
    assert max(scene.daylight.sun) == pytest.approx(3.0)
    assert scene.daylight.zenith == Daylight().zenith
    (note,) = scene.notes
    assert f"{math.log2(3 / lux) * -1:.1f} stops" in note and "lux" in note


def test_lamp_is_exposed_for_objects_in_its_light(tmp_path):
    lamp = {"type": "point", "intensity": 8000.0}
    scene = lit_square(tmp_path, lamp, generator="")
    square_m = 2.0**2
    assert scene.lights[0].intensity[0] / square_m == pytest.approx(3.0)


@pytest.mark.parametrize("intensity", [0.0, 1.0, 25.0])
def test_moderate_light_is_not_exposed(tmp_path, intensity):
    scene = lit_square(tmp_path, {"type": "directional", "intensity": intensity}, generator="")
    assert scene.daylight.sun == (intensity,) * 3 and not scene.notes


def test_lamps_beyond_limit_are_noted(tmp_path):
    scene = lit_square(tmp_path, *[{"type": "point"}] * 33, generator="")
    assert any("32 brightest of 33 lamps" in note for note in scene.notes)


def test_scene_without_lights_has_default_daylight(tmp_path):
    writer = GltfWriter()
    writer.json["asset"]["generator"] = BLENDER
    writer.node(mesh=writer.mesh())
    scene = read_scene(writer.write(tmp_path / "a.glb"))
    assert scene.daylight == Daylight() and not scene.notes
    assert np.isfinite(scene.daylight.sun).all()


def test_lights_follow_their_animated_nodes(tmp_path):
    writer = square_scene()
    lamp = writer.node(**writer.light(type="spot", intensity=5), translation=[0, 0, 2])
    sun = writer.node(**writer.light(type="directional", intensity=3))
    writer.animate(lamp, "translation", [0, 1], [[0, 0, 2], [8, 0, 2]])
    end_rotation = [0, 2**-0.5, 0, 2**-0.5]  # by 90 degrees around y
    writer.animate(sun, "rotation", [0, 1], [[0, 0, 0, 1], end_rotation])
    scene = read_scene(writer.write(tmp_path / "lit.glb"))
    assert scene.is_moving and not scene.notes
    assert scene.lighting_at(1).lights == scene.lights
    lighting = scene.lighting_at(25)
    assert lighting.lights[0].position_m == pytest.approx((8, 0, 2))
    assert lighting.lights[0].intensity == scene.lights[0].intensity
    assert lighting.daylight.to_sun == pytest.approx((1, 0, 0), abs=1e-6)
    assert scene.daylight.to_sun == pytest.approx((0, 0, 1))


def test_raster_lights_scene_by_animated_lamp(tmp_path, session_context):
    """The lamp is in front of the square first and behind it in the end."""
    writer = square_scene()
    lamp = writer.node(**writer.light(type="point", intensity=5))
    writer.animate(lamp, "translation", [0, 1], [[0.5, 0.5, 1], [0.5, 0.5, -1]])
    writer.json["asset"]["generator"] = BLENDER
    raster = SceneRaster(session_context)
    raster.load(read_scene(writer.write(tmp_path / "lit.glb")))
    color = new_texture(session_context, (8, 8), 4)
    view = pose_looking_at((0.5, 0.5, 0.6), (0.5, 0.5, 0)).world_to_camera
    levels = []
    for frame in (1, 25, 1):
        raster.place(frame)
        raster.draw(
            SceneView(
                world_to_camera=view,
                size=(8, 8),
                focal_px=20.0,
                focus_m=np.inf,
                near_m=0.1,
                far_m=100.0,
            ),
            color,
        )
        levels.append(float(download(color)[4, 4, 0]))
    assert levels[0] == levels[2] > 0.1 and levels[1] == 0
    color.release()
    raster.release()
