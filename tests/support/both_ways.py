"""A scene as it is drawn and as it is met by rays, beside each other."""

import numpy as np

from heatlens.core.model.lens.pupil import PINHOLE
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from support.scenes import moved

VIEW = SceneView(moved(0, 0, -3), (32, 32), 50.0, np.inf, 0.5, 20.0)


class BothWays:
    """Both ways to see a scene, from 3 m before it."""

    def __init__(self, ctx: Device) -> None:
        self.raster = SceneRaster(ctx)
        self.tracer = RayTracer(ctx, self.raster)
        self.out = new_texture(ctx, VIEW.size, 4)

    def seen(self, scene: Scene) -> FloatArray:
        """Return (2, H, W, 3).

        The scene as a raster, and by a ray through the middle of each pixel.
        """
        self.raster.load(scene)
        self.raster.place(1)
        self.raster.draw(VIEW, self.out)
        drawn = download(self.out)[..., :3]
        for _ in self.tracer.steps(VIEW, PINHOLE, 1, self.out, object(), pixel_side_px=0.0):
            pass
        return np.stack([drawn, download(self.out)[..., :3]])

    def release(self) -> None:
        self.tracer.release()
        self.raster.release()
        self.out.release()
