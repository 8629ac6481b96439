"""Render a scene by rasterization and by rays, to compare both."""

import numpy as np

from heatlens.core.model.lens.pupil import PINHOLE
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from support.scenes import placement

VIEW = SceneView(placement(0, 0, -3), (32, 32), 50.0, np.inf, 0.5, 20.0)


class RasterAndRays:
    """A rasterizer and a ray tracer of one scene, which is seen from a distance of 3 m."""

    def __init__(self, ctx: Device) -> None:
        self.raster = SceneRaster(ctx)
        self.tracer = RayTracer(ctx, self.raster)
        self.out = new_texture(ctx, VIEW.size, 4)

    def seen(self, scene: Scene) -> FloatArray:
        """Return the colors (2, H, W, 3) of the scene by both renderers.

        The first is rasterized; the second has a ray through the middle of each pixel.
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
