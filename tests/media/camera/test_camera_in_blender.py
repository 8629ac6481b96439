"""The script for Blender, run in Blender itself; skipped where its module is missing."""

import json
import subprocess

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.blender_write import blender_text
from heatlens.media.camera.samples import with_renderer_f_stop
from heatlens.render.source.named import camera_of_shot
from support.blender import PYTHON
from support.patience import PATIENCE_S

FRAMES = FrameRange(101, 126)
# Blender's usual state: a mesh is selected and active, and the camera of the scene is another.
PROBE = """
import bpy, json, sys
scene = bpy.context.scene
other = bpy.data.objects.new("other", bpy.data.cameras.new("other"))
scene.collection.objects.link(other)
before = scene.camera
exec(compile(open(sys.argv[1]).read(), "cam.py", "exec"), {"__name__": "__main__"})
data, found = scene.camera.data, []
for half in range(2 * scene.frame_start, 2 * scene.frame_end + 1):
    scene.frame_set(half // 2, subframe=0.5 * (half % 2))
    dof = data.dof
    found.append((data.lens, dof.aperture_fstop, dof.focus_distance, data["nominal_f_stop"]))
facts = {
    "active": bpy.context.object.name,
    "camera": scene.camera is before,
    "use_dof": data.dof.use_dof,
    "frames": [scene.frame_start, scene.frame_end],
    "rate": scene.render.fps / scene.render.fps_base,
    "sensor_mm": data.sensor_width,
    "other_dof": other.data.dof.use_dof,
    "at_half_frames": found,
}
print("FACTS" + json.dumps(facts))
"""


def shot_with_focus_pull() -> Shot:
    """Return a shot with a focus pull and a closing aperture, on smooth keys."""
    shot = Shot(Lens(50.0, 1.4, 1.1, 36.0), frames=FRAMES, frames_per_second=25.0)
    for frame, focus_m, f_stop in ((101, 1.1, 1.4), (126, 8.0, 2.8)):
        shot = shot.with_key(frame, LensParameter.FOCUS_DISTANCE, focus_m)
        shot = shot.with_key(frame, LensParameter.F_STOP, f_stop)
    return shot


@pytest.mark.skipif(not PYTHON, reason="HEATLENS_BPY_PYTHON names no Python with bpy")
def test_real_blender_has_lens_at_frames_and_linear_between(tmp_path):
    shot = shot_with_focus_pull()
    camera = with_renderer_f_stop(camera_of_shot(shot, "cam"))
    (tmp_path / "cam.py").write_text(blender_text(camera))
    (tmp_path / "probe.py").write_text(PROBE)
    words = [PYTHON, str(tmp_path / "probe.py"), str(tmp_path / "cam.py")]
    process = subprocess.run(words, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert process.returncode == 0, process.stderr
    facts = json.loads(next(x for x in process.stdout.splitlines() if x.startswith("FACTS"))[5:])
    assert facts["active"] == "Cube" and facts["camera"] and facts["use_dof"]
    assert (facts["frames"], facts["rate"]) == ([101, 126], 25.0)
    assert (facts["sensor_mm"], facts["other_dof"]) == (36.0, False)
    focus = [row[2] for row in facts["at_half_frames"]]
    middles = [(a + b) / 2 for a, b in zip(focus[::2], focus[2::2], strict=False)]
    assert focus[1:-1:2] == pytest.approx(middles, rel=1e-5)  # straight from frame to frame
    for half, (focal_mm, f_stop, focus_m, nominal) in enumerate(facts["at_half_frames"]):
        lens = shot.lens_at(101 + half / 2)
        tolerance = 0.01 if half % 2 else 1e-6
        assert focal_mm == 50.0
        assert nominal == pytest.approx(lens.f_stop, rel=tolerance)
        assert focus_m == pytest.approx(lens.focus_distance_m, rel=tolerance)
        same_discs = lens.f_stop * (1 - 0.05 / lens.focus_distance_m)
        assert f_stop == pytest.approx(same_discs, rel=tolerance)
