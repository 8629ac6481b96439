"""Clear a part of a framebuffer, which wgpu itself clears only as a whole."""

import struct
from collections.abc import Sequence
from typing import Any

from heatlens.render.gpu.wgpu.recorder import Recorder

_COLOR_BYTES = 16
# One triangle over the whole framebuffer, at the farthest depth.
_VERTEX = """
@group(0) @binding(0) var<uniform> color: vec4f;
@vertex fn corner(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32(number & 1u), f32(number >> 1u)) * 4.0 - 1.0;
    return vec4f(at, 1.0, 1.0);
}
"""


class AreaClear:
    """Draws a color into all textures of a framebuffer, within the scissor of the pass."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._pipelines: dict[tuple[object, ...], Any] = {}
        self._groups: dict[tuple[object, ...], Any] = {}

    def place_of(self, color: Sequence[float]) -> int:
        """Keep the color of a clear; ask for this before the pass."""
        return self._recorder.place_of(struct.pack("4f", *color))

    def draw(self, draw: Any, formats: tuple[str, ...], depth_format: str, place: int) -> None:
        """Fill the scissor of the render pass `draw`; `depth_format` is "" without depths."""
        key = formats, depth_format
        if key not in self._pipelines:
            self._pipelines[key] = self._pipeline(formats, depth_format)
            self._groups[key] = self._recorder.device.create_bind_group(
                layout=self._pipelines[key][1],
                entries=[
                    {
                        "binding": 0,
                        "resource": {
                            "buffer": self._recorder.uniforms,
                            "offset": 0,
                            "size": _COLOR_BYTES,
                        },
                    }
                ],
            )
        draw.set_pipeline(self._pipelines[key][0])
        draw.set_bind_group(0, self._groups[key], [place])
        draw.draw(3)

    def _pipeline(self, formats: tuple[str, ...], depth_format: str) -> tuple[Any, Any]:
        """Return the pipeline for these textures, and the layout of its bind group."""
        device = self._recorder.device
        module = device.create_shader_module(code=_VERTEX + _fragment(len(formats)))
        entry = {"binding": 0, "visibility": "FRAGMENT"}
        entry["buffer"] = {"type": "uniform", "has_dynamic_offset": True}
        layout = device.create_bind_group_layout(entries=[entry])
        depth = {"format": depth_format, "depth_write_enabled": True, "depth_compare": "always"}
        pipeline = device.create_render_pipeline(
            layout=device.create_pipeline_layout(bind_group_layouts=[layout]),
            vertex={"module": module, "entry_point": "corner"},
            fragment={
                "module": module,
                "entry_point": "fill",
                "targets": [{"format": one} for one in formats],
            },
            primitive={"topology": "triangle-list"},
            depth_stencil=depth if depth_format else None,
        )
        return pipeline, layout


def _fragment(count: int) -> str:
    """Return a fragment shader that writes the color into this number of textures."""
    members = ", ".join(f"@location({k}) color_{k}: vec4f" for k in range(count))
    values = ", ".join(["color"] * count)
    head = f"struct Colors {{ {members} }}\n"
    return f"{head}@fragment fn fill() -> Colors {{ return Colors({values}); }}"
