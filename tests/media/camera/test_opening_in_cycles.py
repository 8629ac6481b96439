"""Compare the disc of a lamp out of focus in Cycles with ours; skipped without bpy."""

import subprocess

import numpy as np
import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.blender_write import blender_text
from heatlens.render.source.named import camera_of_shot
from support.blender import PYTHON
from support.patience import PATIENCE_S

SIDE = 128
LAMP_M, LAMP_RADIUS_M = 4.0, 0.05
LENS = Lens(85.0, 0.5, 1.0, 36.0, model=LensModel.RENDERER)
RENDER = f"""
import bpy, sys, numpy as np
bpy.ops.wm.read_factory_settings(use_empty=True)
exec(compile(open(sys.argv[1]).read(), "cam.py", "exec"), {{"__name__": "__main__"}})
scene = bpy.context.scene
scene.world = bpy.data.worlds.new("night")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
bpy.ops.mesh.primitive_uv_sphere_add(radius={LAMP_RADIUS_M}, location=(0, 0, -{LAMP_M}))
lit = bpy.data.materials.new("lit")
lit.use_nodes = True
nodes = lit.node_tree.nodes
nodes.clear()
glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
glow.inputs["Strength"].default_value = 50.0
lit.node_tree.links.new(glow.outputs[0], out.inputs[0])
bpy.context.object.data.materials.append(lit)
scene.render.engine = "CYCLES"
scene.cycles.samples, scene.cycles.use_denoising = 256, False
scene.cycles.pixel_filter_type, scene.cycles.use_adaptive_sampling = "BOX", False
scene.render.resolution_x = scene.render.resolution_y = {SIDE}
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = sys.argv[2] + ".exr"
bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(sys.argv[2] + ".exr")
image.colorspace_settings.name = "Non-Color"
np.save(sys.argv[2], np.array(image.pixels[:]).reshape({SIDE}, {SIDE}, 4)[::-1, :, 0])
"""


def light_spread_px(light: np.ndarray, axis_weights: tuple[float, float] = (1.0, 1.0)) -> float:
    """Return the standard deviation of light about the image center, with weights for x and y."""
    y, x = np.indices(light.shape) + 0.5 - SIDE / 2
    return float(
        np.sqrt(
            np.sum(light * ((axis_weights[0] * x) ** 2 + (axis_weights[1] * y) ** 2)) / light.sum()
        )
    )


def corner_angle_deg(light: np.ndarray, blades: int) -> float:
    """Return the angle of a corner, counterclockwise from the right, within one blade."""
    y, x = np.indices(light.shape) + 0.5 - SIDE / 2
    wave = np.sum(light * (x - 1j * y) ** blades)
    return float(np.degrees(np.angle(wave)) / blades % (360 / blades))


@pytest.mark.skipif(not PYTHON, reason="HEATLENS_BPY_PYTHON names no Python with bpy")
@pytest.mark.parametrize(
    "opening",
    [{"blades": 6, "blade_rotation_deg": 15.0}, {"blades": 5, "squeeze": 2.0}, {"squeeze": 1.5}],
    ids=["six blades", "five, squeezed", "ellipse"],
)
def test_cycles_renders_lamp_as_disc_of_opening(tmp_path, opening) -> None:
    lens = Lens(85.0, 0.5, 1.0, 36.0, model=LensModel.RENDERER, **opening)
    shot = Shot(lens, frames=FrameRange(1, 1))
    (tmp_path / "cam.py").write_text(blender_text(camera_of_shot(shot, "cam")))
    (tmp_path / "render.py").write_text(RENDER)
    words = [PYTHON, *(str(tmp_path / name) for name in ("render.py", "cam.py", "lamp.npy"))]
    process = subprocess.run(words, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert process.returncode == 0, process.stderr
    cycles = np.load(tmp_path / "lamp.npy").astype(np.float64)
    y, x = np.indices(cycles.shape) + 0.5 - SIDE / 2
    radius_px = float(coc_px(LAMP_M, coc_line(lens, SIDE))) / 2
    ours = DiscShape(lens.aperture).coverage(x, y, radius_px, 0.5)
    lamp_px = LAMP_RADIUS_M / LAMP_M * 85.0 / 36.0 * SIDE
    for axes in ((1.0, 0.0), (0.0, 1.0)):
        lamp_variance_px = lamp_px**2 / 4  # variances add
        expected = np.sqrt(light_spread_px(ours, axes) ** 2 + lamp_variance_px)
        assert light_spread_px(cycles, axes) == pytest.approx(expected, rel=0.02)
    if lens.blades and lens.squeeze == 1.0:
        cycles_deg, our_deg = (corner_angle_deg(light, lens.blades) for light in (cycles, ours))
        assert abs((cycles_deg - our_deg + 30) % 60 - 30) < 2.0
    inside = ours > 0.5
    assert cycles[inside].sum() > 0.8 * cycles.sum()
