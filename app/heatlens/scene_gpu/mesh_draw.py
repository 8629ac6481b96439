"""All instances of a scene in one call, with a fragment shader of choice."""

from collections.abc import Mapping

import moderngl

from heatlens.gpu.program import DrawProgram, Image
from heatlens.scene_gpu.scene_buffers import SceneBuffers

_VERTEX = ("3f 1f 3f 1f", "in_position", "in_u", "in_normal", "in_v")
_BUMPY_VERTEX = ("3f 1f 3f 1f 4f", *_VERTEX[1:], "in_tangent")
_COLOR = ("4f2", "in_color")
_MORE_UV = ("2f", "in_more_uv")
_INSTANCE = ("16f 16f 4u/i", "in_to_world", "in_to_object", "in_numbers")


class MeshDraw:
    """Draws the meshes with scene_mesh.vert.glsl and `fragment`.frag.glsl."""

    def __init__(
        self,
        ctx: moderngl.Context,
        buffers: SceneBuffers,
        fragment: str,
        defines: Mapping[str, object] | None = None,
    ) -> None:
        """Build the program; `defines` come beside those that the scene needs."""
        all_defines = buffers.defines | dict(defines or {})
        self._program = DrawProgram(ctx, "scene_mesh", fragment, all_defines)
        self._buffers = buffers
        more = [] if buffers.colors is None else [(buffers.colors, *_COLOR)]
        more += [] if buffers.more_uvs is None else [(buffers.more_uvs, *_MORE_UV)]
        vertex = _BUMPY_VERTEX if buffers.has_bumps else _VERTEX
        self._array = self._program.vertex_array(
            [(buffers.vertices, *vertex), (buffers.instances, *_INSTANCE), *more],
            buffers.triangles,
        )

    def __call__(
        self,
        uniforms: Mapping[str, object],
        textures: Mapping[str, Image] | None = None,
    ) -> None:
        """Draw into the bound framebuffer; `maps_tx` is the scene's array of maps."""
        buffers = self._buffers
        given = {"maps_tx": buffers.maps} | dict(textures or {})
        self._program.bind(textures=given, uniforms=uniforms, buffers=buffers.storage)
        self._array.render_indirect(buffers.commands, moderngl.TRIANGLES, buffers.command_count)

    def release(self) -> None:
        """Release the program and its vertex array, but not the buffers, which are not its own."""
        self._array.release()
        self._program.release()
