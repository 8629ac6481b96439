"""The add-on in Blender itself, without its window; skipped where its module is missing."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import heatlens
from heatlens.core.model.lens.lens import LensModel
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.read import read_plate
from support.blender import PYTHON
from support.tev_peers import serving, settle

ROOT = Path(__file__).resolve().parents[2]
PROBE = """
import bpy, json, os, sys, time
from pathlib import Path

extension, folder, port = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
bpy.ops.extensions.package_install_files(
    filepath=extension, repo="user_default", enable_on_install=True
)
module = sys.modules["bl_ext.user_default.heatlens"]
scene, render = bpy.context.scene, bpy.context.scene.render
scene.heatlens.folder, scene.heatlens.port = str(folder), port
data = scene.camera.data
data.lens, data.dof.use_dof, data.dof.aperture_fstop, data.dof.focus_distance = 85, True, 2, 11
dof = data.dof
dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.25, 1.5
data["rim"] = 0.5
render.engine, render.resolution_x, render.resolution_y = "CYCLES", 48, 27
render.resolution_percentage, scene.cycles.samples, scene.cycles.use_denoising = 100, 1, False
scene.frame_set(12)
image = render.image_settings


def state():
    return [data.dof.use_dof, image.file_format, image.color_depth, render.filepath,
            render.use_compositing, bpy.context.view_layer.use_pass_z, scene.cycles.samples]


before = state()
bpy.ops.heatlens.render_plate()
facts = {"before": before, "restored": state(), "message": module._FOLLOW.message}
module.LIVE_SAMPLES = (1, 2)
asked = module.asked
module.asked = lambda path, first: facts.setdefault("live", str(path)) and asked(path, first)
bpy.ops.heatlens.live_cycles()
facts["live_mode"] = os.stat(os.path.dirname(facts["live"])).st_mode & 0o777
facts["restored_live"] = state()
shot = module.shot_path(scene)
assert shot.exists(), module._FOLLOW.message
module._FOLLOW.poll(scene)
saved = json.loads(shot.read_text())
saved["lens"]["f_stop"], saved["lens"]["focus_distance_m"] = 1.4, 7.5
for name in ("blades", "blade_rotation_deg", "squeeze"):
    facts[name] = saved["lens"].pop(name)
shot.write_text(json.dumps(saved))
os.utime(shot, (time.time() + 2, time.time() + 2))
for _ in range(600):
    module._FOLLOW.poll(scene)
    if abs(data.dof.focus_distance - 7.5) < 1e-3:
        break
    time.sleep(0.1)
facts["lens"] = [data.lens, data.dof.aperture_fstop, data.dof.focus_distance]
facts["opening"] = [dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio]
facts["own"] = sorted(data.keys())
while module._FOLLOW.is_busy:
    module._FOLLOW.poll(scene)
    time.sleep(0.1)
image = bpy.data.images["heatlens"]
facts["picture"], facts["size"] = list(image.pixels), list(image.size)
bpy.ops.heatlens.show_in_compositor()
render.use_compositing, render.filepath = True, str(folder.parent / "composited.exr")
if hasattr(render.image_settings, "media_type"):
    render.image_settings.media_type = "IMAGE"
render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
bpy.ops.render.render(write_still=True)
front = bpy.data.collections.new("front")
scene.collection.children.link(front)
cube = bpy.data.objects["Cube"]
front.objects.link(cube)
scene.heatlens.foreground = front
scene.heatlens.folder += "_left_out"
dof.aperture_ratio, dof.aperture_blades = 0.7, 40
bpy.ops.heatlens.render_plate()
facts["is_cube_seen"] = cube.visible_camera
facts["left_out"] = module._FOLLOW.message
facts["camera"] = scene.camera.data.name == data.name
facts["followed"] = module._FOLLOW.message
bpy.ops.preferences.addon_disable(module="bl_ext.user_default.heatlens")
print("FACTS" + json.dumps(facts))
"""


def rgb_of(path) -> np.ndarray:
    planes = read_parts(path)[0][1]
    return np.stack([planes[name] for name in "RGB"], axis=-1).astype(np.float32)


pytestmark = pytest.mark.skipif(not PYTHON, reason="HEATLENS_BPY_PYTHON names no Python with bpy")


@pytest.fixture
def extension_file(tmp_path):
    path = tmp_path / "heatlens.zip"
    assert main(["addon", "build", "-o", str(path)]) == 0
    return path


def test_extension_is_valid_for_blenders_own_check(extension_file):
    code = "import bpy; print(bpy.utils.system_resource('SCRIPTS'))"
    run = subprocess.run([PYTHON, "-c", code], capture_output=True, text=True, check=True)
    folder = Path(run.stdout.splitlines()[-1])
    (check,) = folder.rglob("bl_pkg/cli/blender_ext.py")
    words = [PYTHON, str(check), "validate", str(extension_file)]
    run = subprocess.run(words, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr


def test_addon_renders_plate_sends_live_picture_and_reads_lens_back(tmp_path, extension_file):
    (tmp_path / "probe.py").write_text(PROBE)
    folder = tmp_path / "plates"
    with serving() as server:
        words = [PYTHON, tmp_path / "probe.py", extension_file, folder, server.address[1]]
        process = subprocess.run(
            list(map(str, words)),
            env=os.environ
            | {
                "HEATLENS": f"{sys.executable} -m heatlens",
                "BLENDER_USER_RESOURCES": str(tmp_path / "blender"),
            },
            capture_output=True,
            text=True,
            check=False,
            timeout=400,
        )
        assert process.returncode == 0, process.stderr
        settle(server)
        live_plate = server.snapshot()
    facts = json.loads(next(x for x in process.stdout.splitlines() if x.startswith("FACTS"))[5:])
    assert facts["restored"] == facts["restored_live"] == facts["before"]

    plate = read_plate(next(folder.glob("*.0012.exr")))
    assert plate.color.shape == (27, 48, 4) and plate.camera.model is LensModel.RENDERER
    assert plate.depth_m is not None and 5 < plate.depth.near_m < 11 < plate.depth.far_m < 100
    camera = read_camera(str(next(folder.glob("*.camera.json"))))
    assert (camera.frames, camera.up_axis) == ((12,), "z")
    assert (camera.focal_length_mm, camera.f_stop, camera.sensor_width_mm) == ((85,), (2,), (36,))
    shot = read_shot(next(folder.glob("*.heatlens.json")))
    assert shot.lens.focal_length_mm == 85 and shot.lens.model is LensModel.RENDERER

    assert live_plate is not None and live_plate.color.shape == (27, 48, 4)
    assert (live_plate.camera.focal_length_mm, live_plate.camera.focus_distance_m) == (85, 11)
    np.testing.assert_allclose(np.median(live_plate.depth_m), np.median(plate.depth_m), rtol=1e-3)

    assert facts["lens"] == pytest.approx([85, 1.4, 7.5], rel=1e-6), facts["followed"]
    assert facts["camera"]
    assert facts["live_mode"] == 0o700
    aperture_values = [facts[name] for name in ("blades", "blade_rotation_deg", "squeeze")]
    # A corner at 0.25 + pi / 5, where Blender's stands; the nearest one to the top is the third.
    corner_deg = math.degrees(0.25 + math.pi / 5) + 72 - 90
    assert aperture_values == pytest.approx([5, corner_deg, 1.5], abs=1e-4)
    # The shot that came back is round, so the camera is, and has no rim of an earlier shot.
    assert (facts["opening"], facts["own"]) == ([0, 0, 1], [])
    # The picture that came back is the one of `heatlens render`, in the compositor too.
    assert facts["size"] == [48, 27]
    picture = np.array(facts["picture"]).reshape(27, 48, 4)[::-1, :, :3]
    rendered = heatlens.open(next(folder.glob("*.heatlens.json"))).render()[..., :3]
    np.testing.assert_allclose(picture, rendered, rtol=1e-3, atol=1e-5)  # the file is half float
    composited = rgb_of(tmp_path / "composited.exr")
    np.testing.assert_allclose(composited, rendered, rtol=1e-3, atol=1e-5)
    assert "ratio 0.7" in facts["left_out"] and "40 blades" in facts["left_out"]
    second_folder = folder.with_name("plates_left_out")
    second_shot = read_shot(next(second_folder.glob("*.heatlens.json")))
    assert (second_shot.lens.blades, second_shot.lens.squeeze) == (0, 1.0)
    # Without the foreground the middle of the plate shows the sky, and the shot knows the file.
    (behind_file,) = second_shot.plate_options.behind
    behind_plate = read_plate(Path(behind_file))
    assert behind_plate.depth_m is not None and plate.depth_m[13, 24] < 12
    assert behind_plate.depth_m[13, 24] > 1000 and facts["is_cube_seen"]


INSTALL_PROBE = """
import bpy, sys, time
from pathlib import Path

extension, wheel = sys.argv[1:]
bpy.ops.extensions.package_install_files(
    filepath=extension, repo="user_default", enable_on_install=True
)
program = sys.modules["bl_ext.user_default.heatlens.program"]
preferences = program.preferences_of_addon()
preferences.package = wheel
bpy.context.preferences.system.use_online_access = True
bpy.ops.heatlens.install()
while program.INSTALL.is_busy:
    program.INSTALL.poll()
    time.sleep(0.1)
print(program.INSTALL.message)
print("SAID", program.ran("--version").strip(), "FROM", program.command()[0])
"""


def test_install_button_makes_environment_with_heatlens_of_its_own(tmp_path, extension_file):
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "--wheel-dir", str(tmp_path), str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("heatlens-*.whl")
    (tmp_path / "probe.py").write_text(INSTALL_PROBE)
    process = subprocess.run(
        [PYTHON, tmp_path / "probe.py", extension_file, wheel],
        env=os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path / "blender"), "HEATLENS": "none"},
        capture_output=True,
        text=True,
        check=False,
        timeout=400,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    said = next(line for line in process.stdout.splitlines() if line.startswith("SAID"))
    version, _, program = said.removeprefix("SAID ").partition(" FROM ")
    assert version.endswith(heatlens.__version__)
    assert Path(program).is_relative_to(tmp_path / "blender")
