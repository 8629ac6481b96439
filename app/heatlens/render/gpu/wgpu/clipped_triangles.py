"""Draw lists of clipped triangles with a texture each, as interfaces are made of."""

import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

from heatlens.render.gpu.framebuffer import Blend, Framebuffer
from heatlens.render.gpu.wgpu.buffers import WgBuffer
from heatlens.render.gpu.wgpu.framebuffers import BLENDS, WgFramebuffer, area_inside
from heatlens.render.gpu.wgpu.recorder import Recorder
from heatlens.render.gpu.wgpu.textures import texture_of

_WINDOW_BYTES = 16
_SHADERS = """
struct Window { scale: vec2f, shift: vec2f }
struct Corner {
    @builtin(position) position: vec4f, @location(0) at: vec2f, @location(1) color: vec4f
}
@group(0) @binding(0) var<uniform> window: Window;
@group(0) @binding(1) var linear: sampler;
@group(1) @binding(0) var picture: texture_2d<f32>;
@vertex fn corner(
    @location(0) place: vec2f, @location(1) at: vec2f, @location(2) color: vec4f
) -> Corner {
    return Corner(vec4f(place * window.scale + window.shift, 0.0, 1.0), at, color);
}
@fragment fn fill(corner: Corner) -> @location(0) vec4f {
    return corner.color * textureSample(picture, linear, corner.at);
}
"""
# of a vertex: its place, its place in the texture, and a color of four bytes
_VERTEX: dict[str, Any] = {
    "array_stride": 20,
    "step_mode": "vertex",
    "attributes": [
        {"format": "float32x2", "offset": 0, "shader_location": 0},
        {"format": "float32x2", "offset": 8, "shader_location": 1},
        {"format": "unorm8x4", "offset": 16, "shader_location": 2},
    ],
}


class Clipped(NamedTuple):
    """Triangles that share a texture and a clip.

    texture       the handle of the texture
    clip          left, top, right and bottom in pixels, y down
    index_count, first_index, first_vertex  which triangles, in the buffers of the draw
    """

    texture: int
    clip: tuple[float, float, float, float]
    index_count: int
    first_index: int
    first_vertex: int


class ClippedTriangles:
    """Draws triangles whose places are in units of a window, y down."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._vertices, self._indices = (WgBuffer(recorder, 1 << 16, False) for _ in range(2))
        device = recorder.device
        self._sampler = device.create_sampler(mag_filter="linear", min_filter="linear")
        uniforms = {"type": "uniform", "has_dynamic_offset": True}
        layouts = (
            [
                {"binding": 0, "visibility": "VERTEX", "buffer": uniforms},
                {"binding": 1, "visibility": "FRAGMENT", "sampler": {}},
            ],
            [{"binding": 0, "visibility": "FRAGMENT", "texture": {}}],
        )
        self._layouts = [device.create_bind_group_layout(entries=one) for one in layouts]
        self._groups: dict[int, tuple[Any, Any]] = {}  # by handle: a view, and its bind group
        part = {"buffer": recorder.uniforms, "offset": 0, "size": _WINDOW_BYTES}
        self._window_group = device.create_bind_group(
            layout=self._layouts[0],
            entries=[{"binding": 0, "resource": part}, {"binding": 1, "resource": self._sampler}],
        )
        self._pipelines: dict[str, Any] = {}

    def draw(
        self,
        target: Framebuffer,
        window: tuple[float, float, float, float],
        size_px: tuple[int, int],
        vertices: bytes,
        indices: bytes,
        parts: Iterable[Clipped],
    ) -> None:
        """Draw `parts`, one over the other, into `target`.

        `window` is left, top, width and height in units, and `size_px` the same size in pixels.
        """
        assert isinstance(target, WgFramebuffer)
        for buffer, content in ((self._vertices, vertices), (self._indices, indices)):
            if len(content) > buffer.size:
                buffer.orphan(2 * len(content))
            buffer.write(content)
        left, top, width, height = window
        scale = 2.0 / width, 2.0 / height
        shift = -1.0 - left * scale[0], -1.0 - top * scale[1]
        place = self._recorder.place_of(struct.pack("4f", *scale, *shift))
        draw = self._recorder.render_pass(target, target.attachments())
        draw.set_pipeline(self._pipeline(target.textures[0].format))
        draw.set_viewport(0, 0, *size_px, 0.0, 1.0)
        draw.set_bind_group(0, self._window_group, [place])
        draw.set_vertex_buffer(0, self._vertices.raw)
        draw.set_index_buffer(self._indices.raw, "uint32")
        for part in parts:
            self._draw_part(draw, part, target.size, size_px[1])

    def _draw_part(self, draw: Any, part: Clipped, size: tuple[int, int], height_px: int) -> None:
        """Draw the triangles of one part, unless its texture was released or nothing is inside."""
        x0, y0, x1, y1 = part.clip  # y down, while the rows of the target run up
        area = int(x0), int(height_px - y1), int(x1 - x0), int(y1 - y0)
        area, texture = area_inside(area, size), texture_of(part.texture)
        if texture is not None and min(area[2:]) > 0:
            draw.set_scissor_rect(*area)
            draw.set_bind_group(1, self._texture_group(part.texture, texture.view))
            draw.draw_indexed(part.index_count, 1, part.first_index, part.first_vertex)

    def _texture_group(self, handle: int, view: Any) -> Any:
        """Return the bind group of a texture; those of released textures are dropped."""
        if handle not in self._groups or self._groups[handle][0] is not view:
            self._groups = {it: kept for it, kept in self._groups.items() if texture_of(it)}
            entries = [{"binding": 0, "resource": view}]
            group = self._recorder.device.create_bind_group(
                layout=self._layouts[1], entries=entries
            )
            self._groups[handle] = view, group
        return self._groups[handle][1]

    def _pipeline(self, format_: str) -> Any:
        """Return the pipeline that draws into textures of a format, made on first use."""
        if format_ not in self._pipelines:
            device = self._recorder.device
            module = device.create_shader_module(code=_SHADERS)
            color = {"format": format_, "blend": BLENDS[Blend.OVER]}
            self._pipelines[format_] = device.create_render_pipeline(
                layout=device.create_pipeline_layout(bind_group_layouts=self._layouts),
                vertex={"module": module, "entry_point": "corner", "buffers": [_VERTEX]},
                fragment={"module": module, "entry_point": "fill", "targets": [color]},
                primitive={"topology": "triangle-list"},
            )
        return self._pipelines[format_]

    def release(self) -> None:
        """Give the buffers back."""
        self._vertices.release()
        self._indices.release()
        self._groups.clear()
