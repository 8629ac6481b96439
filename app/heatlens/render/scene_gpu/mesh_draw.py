"""Draw the instances of a scene, with a chosen fragment shader.

The shadow map of the sun is drawn the same way: one depth map of the whole scene.
"""

from collections.abc import Mapping

import numpy as np

from heatlens.media.scene.scene import Array
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import DepthTest, Primitive
from heatlens.render.gpu.program import DrawProgram
from heatlens.render.gpu.resources import Image
from heatlens.render.scene_gpu.scene_buffers import Instances, SceneBuffers

# Formats of moderngl, and the inputs of the vertex shader that they feed; "/i" is per instance.
_VERTEX = ("3f 1f 3f 1f", "in_position", "in_u", "in_normal", "in_v")
_BUMPY_VERTEX = ("3f 1f 3f 1f 4f", *_VERTEX[1:], "in_tangent")
_COLOR = ("4f2", "in_color")
_MORE_UV = ("2f", "in_more_uv")
_INSTANCE_FORMAT = f"{'4f ' * 8}4u/i"
_INSTANCE = (
    *(f"in_{name}_{axis}" for name in ("to_world", "to_object") for axis in "xyzw"),
    "in_numbers",
)
SIDE_PX = 2048  # side of the shadow map
_BORDER_PX = 2  # empty texels around the map, so that its edge casts no shadow


class MeshDraw:
    """Draws `instances` with scene_mesh.vert.glsl and `fragment`.frag.glsl."""

    def __init__(
        self,
        ctx: Device,
        buffers: SceneBuffers,
        fragment: str,
        defines: Mapping[str, object] | None = None,
        instances: Instances = Instances.ALL,
    ) -> None:
        """Build the program; `defines` are added to those that the scene needs."""
        all_defines = buffers.defines | dict(defines or {})
        if instances is not Instances.HOLED:
            all_defines.pop("HOLES", None)
        self._program = DrawProgram(ctx, "scene_gpu/scene_mesh", fragment, all_defines)
        self._buffers, self._instances = buffers, instances
        extra_layouts = [] if buffers.colors is None else [(buffers.colors, *_COLOR)]
        extra_layouts += [] if buffers.more_uvs is None else [(buffers.more_uvs, *_MORE_UV)]
        vertex = _BUMPY_VERTEX if buffers.has_bumps else _VERTEX
        self._array = self._program.vertex_array(
            [
                (buffers.vertices, *vertex),
                (buffers.instances, _INSTANCE_FORMAT, *_INSTANCE),
                *extra_layouts,
            ],
            buffers.triangles,
        )

    def __call__(
        self, uniforms: Mapping[str, object], textures: Mapping[str, Image] | None = None
    ) -> None:
        """Draw the instances into the bound framebuffer.

        `textures` are those besides the scene's own.
        """
        buffers = self._buffers
        commands, count = buffers.commands[self._instances]
        if count:
            all_textures = buffers.textures | dict(textures or {})
            self._program.bind(textures=all_textures, uniforms=uniforms, buffers=buffers.storage)
            self._array.render_indirect(commands, Primitive.TRIANGLES, count)

    def release(self) -> None:
        """Release the program and its vertex array; the buffers belong to the scene."""
        self._array.release()
        self._program.release()


# A program that looks for holes takes twice as long for each pixel on a processor, even where a
# surface has none.
class DepthDraw:
    """Draws the depth of all instances; only those with holes are searched for them."""

    def __init__(
        self,
        ctx: Device,
        buffers: SceneBuffers,
        fragment: str,
        defines: Mapping[str, object] | None = None,
    ) -> None:
        """Build the programs, one for each kind of instances in the scene; see `MeshDraw`."""
        kinds = [kind for kind in (Instances.SOLID, Instances.HOLED) if buffers.commands[kind][1]]
        self._draws = [MeshDraw(ctx, buffers, fragment, defines, kind) for kind in kinds]

    def __call__(
        self, uniforms: Mapping[str, object], textures: Mapping[str, Image] | None = None
    ) -> None:
        """Draw into the bound framebuffer; see `MeshDraw`."""
        for draw in self._draws:
            draw(uniforms, textures)

    def release(self) -> None:
        """Release the programs."""
        for draw in self._draws:
            draw.release()


class ShadowPass:
    """Draws the shadow map of the sun.

    map         depths seen from the sun; a sampler2DShadow compares with them and blends the
                results of four texels
    from_world  (4, 4) matrix from the world to the map, 0..1 along all three axes
    texel_m     width of a texel in the world, meters
    """

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self.map = ctx.shadow_map((SIDE_PX, SIDE_PX))
        self._target = ctx.framebuffer(depth=self.map)
        self.from_world = np.eye(4)
        self.texel_m = 0.0

    def draw(self, cover: DepthDraw, corners_m: Array, to_sun: Array) -> None:
        """Draw a scene whose boxes have `corners_m` (N, 3), lit from the unit vector `to_sun`.

        `cover` draws the scene's depth alone.
        """
        clip, self.texel_m = sun_view(corners_m, to_sun)
        half = np.diag([0.5, 0.5, 0.5, 1.0])
        half[:3, 3] = 0.5
        self.from_world = half @ clip
        self._target.use()
        self._target.clear()
        self._ctx.draw_with(depth=DepthTest.LESS)
        one_sample = {"draw_number": -1, "samples_across": 1, "first_row": 0, "rows_above": 0}
        cover({"clip_from_world": tuple(clip.T.ravel()), **one_sample})
        self._ctx.draw_with()

    def release(self) -> None:
        """Release the map, whose framebuffer must not be bound."""
        self._target.release()
        self.map.release()


def sun_view(corners_m: Array, to_sun: Array) -> tuple[Array, float]:
    """Return the matrix (4, 4) from the world to the sun's clip space, and the width of a texel.

    `corners_m` (N, 3) are positions in the world, which the clip space encloses tightly. `to_sun`
    is the unit vector towards the sun. The width is in meters.
    """
    other_axis = np.eye(3)[int(np.argmin(np.abs(to_sun)))]
    right = np.cross(other_axis, to_sun)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(to_sun, right), -to_sun])
    points = corners_m @ axes.T
    low, high = points.min(axis=0), points.max(axis=0)
    center = (low + high) / 2
    half = np.maximum((high - low) / 2, 1e-6 + 1e-4 * float((high - low).max()))
    half *= 1 + 2 * _BORDER_PX / SIDE_PX
    clip = np.eye(4)
    clip[:3, :3] = axes / half[:, None]
    clip[:3, 3] = -center / half
    return clip, float(2 * half[:2].max() / SIDE_PX)
