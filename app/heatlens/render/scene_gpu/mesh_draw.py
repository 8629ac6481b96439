"""Draw the instances of a scene, with a chosen fragment shader.

The shadow map of the sun is drawn the same way: one depth map of the whole scene.
"""

from collections.abc import Mapping

import numpy as np

from heatlens.media.scene.scene import Array
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import DepthTest, Primitive
from heatlens.render.gpu.program import DrawProgram, VertexArray
from heatlens.render.gpu.resources import Image
from heatlens.render.scene_gpu.scene_buffers import Instances, Kinds, SceneBuffers

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
    """Draws all instances with scene_mesh.vert.glsl and `fragment`.frag.glsl.

    Each kind of instances has a program of its own, which reads only what they need.
    """

    def __init__(
        self,
        ctx: Device,
        buffers: SceneBuffers,
        fragment: str,
        kinds: Kinds,
        defines: Mapping[str, object] | None = None,
    ) -> None:
        """Build the programs; `defines` are added to those that the scene needs.

        `kinds` are BY_HOLES for a shader that draws depth, BY_MAPS for one that draws light.
        """
        self._buffers = buffers
        self._draws: dict[Instances, tuple[DrawProgram, VertexArray]] = {}
        for kind in kinds:
            if buffers.commands[kind][1]:
                all_defines = buffers.defines_of(kind) | dict(defines or {})
                program = DrawProgram(ctx, "scene_gpu/scene_mesh", fragment, all_defines)
                self._draws[kind] = program, _vertex_array(program, buffers)

    def __call__(
        self, uniforms: Mapping[str, object], textures: Mapping[str, Image] | None = None
    ) -> None:
        """Draw the instances into the bound framebuffer.

        `textures` are those besides the scene's own.
        """
        buffers = self._buffers
        all_textures = buffers.textures | dict(textures or {})
        for kind, (program, array) in self._draws.items():
            commands, count = buffers.commands[kind]
            if count:
                program.bind(textures=all_textures, uniforms=uniforms, buffers=buffers.storage)
                array.render_indirect(commands, Primitive.TRIANGLES, count)

    def release(self) -> None:
        """Release the programs and their vertex arrays; the buffers belong to the scene."""
        for program, array in self._draws.values():
            array.release()
            program.release()


def _vertex_array(program: DrawProgram, buffers: SceneBuffers) -> VertexArray:
    """Return the vertices of a scene as a program reads them."""
    extra_layouts = [] if buffers.colors is None else [(buffers.colors, *_COLOR)]
    extra_layouts += [] if buffers.more_uvs is None else [(buffers.more_uvs, *_MORE_UV)]
    vertex = _BUMPY_VERTEX if buffers.has_bumps else _VERTEX
    return program.vertex_array(
        [
            (buffers.vertices, *vertex),
            (buffers.instances, _INSTANCE_FORMAT, *_INSTANCE),
            *extra_layouts,
        ],
        buffers.triangles,
    )


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

    def draw(self, cover: MeshDraw, corners_m: Array, to_sun: Array) -> None:
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
