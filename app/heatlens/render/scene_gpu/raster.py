"""Draw a scene as triangles: through one point of the lens, or as a pinhole picture with depth.

The depth of all triangles is drawn first, then the light of the visible ones, so that each pixel is
shaded once.
"""

import math
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from heatlens.core.model.boxes import Box
from heatlens.media.scene.scene import Array, Daylight, Scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.draw_target import DrawTargets
from heatlens.render.gpu.framebuffer import DepthTest, Framebuffer, Primitive
from heatlens.render.gpu.program import DrawProgram
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.textures import FloatArray
from heatlens.render.scene_gpu.bands import Bands
from heatlens.render.scene_gpu.mesh_draw import MeshDraw, ShadowPass
from heatlens.render.scene_gpu.scene_buffers import BY_HOLES, BY_MAPS, SceneBuffers
from heatlens.render.scene_gpu.scene_records import light_uniforms
from heatlens.render.scene_gpu.sky_light import diffuse_polynomial
from heatlens.render.scene_gpu.view_uniforms import (
    columns,
    cover_uniforms,
    eye_uniforms,
    mesh_uniforms,
    sample_uniforms,
    sky_uniforms,
)


class SceneRaster:
    """Holds one scene on the GPU and draws it."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self.targets = DrawTargets(ctx)
        self._shadow = ShadowPass(ctx)
        self._sky = SkyDraw(ctx)
        self._done = DrawProgram(ctx, "scene_gpu/scene_done")
        self._done_array = self._done.vertex_array([])
        self._buffers: SceneBuffers | None = None
        self._placed_transforms: Array | None = None
        self._frame = 0.0  # the frame at which the scene is placed
        self._bounds: tuple[SceneView, Array] | None = None  # a view, and its `pixel_bounds`

    @property
    def buffers(self) -> SceneBuffers:
        """The loaded scene on the GPU; there must be one."""
        assert self._buffers is not None
        return self._buffers

    @property
    def frame(self) -> float:
        """The frame at which the scene is placed."""
        return self._frame

    @property
    def shadow_map(self) -> Texture:
        """`shadow_tx` of lib/shading.lib.glsl."""
        return self._shadow.map

    def load(self, scene: Scene) -> None:
        """Load a scene in place of the previous one; call `place` before drawing it.

        Then `cover` draws only the depth of visible surfaces.
        """
        self._unload()
        self._buffers = SceneBuffers(self._ctx, scene)
        self.bands = Bands(self._ctx, self._buffers.triangles_drawn)
        self.cover, self._depth = (
            MeshDraw(self._ctx, self._buffers, f"scene_gpu/scene_{name}", BY_HOLES)
            for name in ("cover", "depth")
        )
        self._surface = MeshDraw(self._ctx, self._buffers, "scene_gpu/scene_surface", BY_MAPS)
        self._daylight, self._lights = scene.daylight, light_uniforms(scene.lights)
        self._sky_light = diffuse_polynomial(scene.daylight)

    def place(self, frame: float) -> None:
        """Move all instances to their poses at a frame and draw the shadow map, if any moved."""
        scene = self.buffers.scene
        if self._placed_transforms is not None and (not scene.is_moving or frame == self._frame):
            return
        transforms = scene.transforms_at(frame)
        is_same = self._placed_transforms is not None and np.array_equal(
            transforms, self._placed_transforms
        )
        if is_same and not scene.deforms and scene.light_motion is None:
            return
        self._placed_transforms, self._frame = np.array(transforms), frame
        self.buffers.place(transforms)
        self.buffers.reshape(scene.shapes_at(frame))
        self._corners_m, self._bounds = self.buffers.corners_m(transforms), None
        lighting = scene.lighting_at(frame)
        self._daylight, self._lights = lighting.daylight, light_uniforms(lighting.lights)
        if max(self._daylight.sun) > 0:
            corners, to_sun = self._corners_m.reshape(-1, 3), sun_direction(self._daylight)
            self._shadow.draw(self.cover, corners, to_sun)

    def shading_uniforms(self) -> dict[str, object]:
        """Return the uniforms of lib/shading.lib.glsl.

        Its textures are `buffers.maps` and `shadow_map`.
        """
        daylight = self._daylight
        return {
            "to_sun": tuple(sun_direction(daylight)),
            "sun_light": daylight.sun,
            "sky_zenith": daylight.zenith,
            "sky_horizon": daylight.horizon,
            "sky_ground": daylight.ground,
            "sky_light": tuple(tuple(row) for row in self._sky_light),
            "shadow_from_world": columns(self._shadow.from_world),
            "shadow_texel_m": self._shadow.texel_m,
            **self._lights,
        }

    def draw(self, view: SceneView, color: Texture, band: Box | None = None) -> None:
        """Draw one sample a pixel, at the view's jitter, into RGBA `color` with an alpha of 1.

        With `band` only these rows are drawn.
        """
        with self.bind_band(self.targets.of(color), view, band) as target:
            target.clear()
            self.draw_into(target, view, self.cover, self._surface, self._sky)

    def depth(self, view: SceneView, depth: Texture, band: Box | None = None) -> None:
        """Draw planar meters at the view's jitter into `depth`, R float32; +inf for sky."""
        with self.bind_band(self.targets.of(depth), view, band) as target:
            target.clear(red=math.inf)
            self._ctx.draw_with(depth=DepthTest.LESS)
            self._depth(cover_uniforms(replace(view, sample=None)))
            self._ctx.draw_with()

    @contextmanager
    def bind_band(
        self, target: Framebuffer, view: SceneView, band: Box | None
    ) -> Iterator[Framebuffer]:
        """Bind a target, and restrict drawing to a band of a view, until the block ends.

        None as `band` draws everywhere.
        """
        if band is not None and band.shape != target.size[::-1]:  # else clearing would be slower
            target.scissor = band.x0, view.rows_above + band.y0, band.width, band.height
        target.use()
        try:
            with self._draw_only_in(view, band):
                yield target
        finally:
            target.scissor = None

    # Every band would process the vertices of the whole scene.
    def _draw_only_in(self, view: SceneView, band: Box | None) -> AbstractContextManager[None]:
        """Leave out what a band of a view cannot show, until the block ends."""
        if band is None or not self.bands.are_small:
            return nullcontext()
        return self.buffers.draw_only(self.may_show(view, band))

    def may_show(self, view: SceneView, pixels: Box) -> npt.NDArray[np.bool_]:
        """Return (N,) whether each instance may be seen in some pixels of a view."""
        if self._bounds is None or self._bounds[0] is not view:
            self._bounds = view, view.pixel_bounds(self._corners_m)
        left, right, top, bottom = self._bounds[1]
        # one pixel more on every side, for what is rounded
        columns_meet = (left < pixels.x1 + 1) & (right > pixels.x0 - 1)
        may_show: npt.NDArray[np.bool_] = (
            columns_meet & (top < pixels.y1 + 1) & (bottom > pixels.y0 - 1)
        )
        return may_show

    def hide_done_pixels(self, target: Framebuffer, view: SceneView, done: Texture) -> None:
        """Cover the pixels where `done`, R, is not 0 with a depth nearer than everything else.

        Later draws then write nothing there.

        `done` has a texel for each pixel, and the view several samples. `target` is bound.
        """
        self._ctx.draw_with(depth=DepthTest.ALWAYS)
        target.writes_color = False
        self._done.bind(textures={"done_tx": done}, uniforms=sample_uniforms(view))
        self._done_array.render(Primitive.TRIANGLES, 3)
        target.writes_color = True
        self._ctx.draw_with(depth=DepthTest.LESS)

    def depth_at(self, view: SceneView, frame: float, depth: Texture) -> None:
        """Draw the depth of another frame into `depth`, R float32, then restore this one."""
        scene = self.buffers.scene
        if self._placed_transforms is None or not scene.is_moving:
            self.place(frame)
            self.depth(view, depth)
            return
        self.buffers.place(scene.transforms_at(frame))
        self.buffers.reshape(scene.shapes_at(frame))
        self.depth(view, depth)
        self.buffers.place(self._placed_transforms)
        self.buffers.reshape(scene.shapes_at(self._frame))

    def read(self, texture: Texture, area: Box) -> FloatArray:
        """Read a small area: (h, w) float32 of one component, (h, w, C) of more."""
        viewport = (area.x0, area.y0, area.width, area.height)
        data = self.targets.of(texture).read(viewport, texture.components, dtype="f4")
        pixels = np.frombuffer(data, np.float32)
        return pixels.reshape(area.shape if texture.components == 1 else (*area.shape, -1))

    def draw_into(
        self,
        target: Framebuffer,
        view: SceneView,
        cover: MeshDraw,
        surface: MeshDraw,
        sky: "SkyDraw",
        peeled_uniforms: Mapping[str, object] | None = None,
        peeled_textures: Mapping[str, Texture] | None = None,
    ) -> None:
        """Draw the visible surfaces and the sky into the bound, cleared target.

        `cover` draws depth alone; `surface` then shades where the depth is equal, so that each
        pixel is shaded once. `sky` fills the rest.

        `peeled_uniforms` and `peeled_textures` are the further inputs of a cover with PEEL.
        """
        meshes, shading = mesh_uniforms(view), self.shading_uniforms()
        textures = {"shadow_tx": self._shadow.map}
        self._ctx.draw_with(depth=DepthTest.LESS)
        target.writes_color = False
        cover(cover_uniforms(view) | dict(peeled_uniforms or {}), peeled_textures)
        target.writes_color = True
        target.writes_depth = False
        self._ctx.draw_with(depth=DepthTest.EQUAL)
        surface(meshes | shading | eye_uniforms(view), textures)
        self._ctx.draw_with(depth=DepthTest.AT_MOST)
        sky.draw(textures, shading | sky_uniforms(view), self.buffers.storage)
        target.writes_depth = True
        self._ctx.draw_with()

    def _unload(self) -> None:
        """Release the scene, but keep what the next scene can use."""
        if self._buffers is not None:
            for resource in (self.cover, self._depth, self._surface, self._buffers):
                resource.release()
        self._buffers, self._placed_transforms = None, None

    def release(self) -> None:
        """Release everything on the GPU."""
        self._unload()
        self.targets.release()
        self._shadow.release()
        self._sky.release()
        self._done.release()


class SkyDraw:
    """Draws the sky behind everything drawn before."""

    def __init__(self, ctx: Device, defines: Mapping[str, object] | None = None) -> None:
        self._program = DrawProgram(ctx, "scene_gpu/scene_sky", defines=defines)
        self._array = self._program.vertex_array([])

    def draw(
        self,
        textures: Mapping[str, Texture],
        uniforms: Mapping[str, object],
        storage: Mapping[str, Buffer],
    ) -> None:
        """Draw into the bound framebuffer."""
        self._program.bind(textures=textures, uniforms=uniforms, buffers=storage)
        self._array.render(Primitive.TRIANGLES, 3)

    def release(self) -> None:
        """Release everything on the GPU."""
        self._array.release()
        self._program.release()


def sun_direction(daylight: Daylight) -> Array:
    """Return the unit vector (3,) towards the sun; straight up for a vector of length 0."""
    length = float(np.linalg.norm(daylight.to_sun))
    return np.divide(daylight.to_sun, length) if length > 1e-12 else np.array([0.0, 1.0, 0.0])
