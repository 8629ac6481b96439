"""Bring a picture into a window of the system, by a surface of wgpu."""

from collections.abc import Mapping
from typing import Any

import wgpu

from heatlens.core.base.log import LOG
from heatlens.render.gpu.wgpu.recorder import Recorder
from heatlens.render.gpu.wgpu.textures import WgTexture

# One triangle over the window. The rows of a picture run up and those of a window down.
_COPY = """
@group(0) @binding(0) var picture: texture_2d<f32>;
@vertex fn corner(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32(number & 1u), f32(number >> 1u)) * 4.0 - 1.0;
    return vec4f(at, 0.0, 1.0);
}
@fragment fn copy(@builtin(position) place: vec4f) -> @location(0) vec4f {
    let last = vec2i(textureDimensions(picture)) - 1;
    let at = vec2i(place.xy);
    return vec4f(textureLoad(picture, vec2i(min(at.x, last.x), max(last.y - at.y, 0)), 0).rgb, 1.0);
}
"""


class WgSurface:
    """The pixels of one window, which the system shows.

    `present_info` names the window in the words of wgpu. `waits` lets `show` wait for the refresh
    of the monitor.
    """

    def __init__(self, recorder: Recorder, present_info: Mapping[str, object], waits: bool) -> None:
        self._recorder = recorder
        self._context: Any = wgpu.gpu.get_canvas_context({**present_info, "vsync": waits})
        device = recorder.device
        format_ = _plain_format(self._context, device.adapter)
        self._context.configure(device=device, format=format_)
        module = device.create_shader_module(code=_COPY)
        self._pipeline = device.create_render_pipeline(
            layout="auto",
            vertex={"module": module, "entry_point": "corner"},
            fragment={"module": module, "entry_point": "copy", "targets": [{"format": format_}]},
            primitive={"topology": "triangle-list"},
        )
        self._copied: tuple[Any, Any] = None, None  # the view of a picture, and its bind group

    def show(self, picture: WgTexture) -> None:
        """Show a picture of the size of the window, or nothing while the window is hidden."""
        self._context.set_physical_size(*picture.size)
        try:
            pixels = self._context.get_current_texture()
        except wgpu.classes.DrawCancelled as reason:  # covered, or its size changes right now
            LOG.debug("a frame was not shown: %s", reason)
            self._recorder.submit()
            return
        color = {"view": pixels.create_view(), "load_op": "clear", "store_op": "store"}
        draw = self._recorder.encoder().begin_render_pass(color_attachments=[color])
        draw.set_pipeline(self._pipeline)
        draw.set_bind_group(0, self._group(picture))
        draw.draw(3)
        draw.end()
        self._recorder.submit()
        self._context.present()

    def _group(self, picture: WgTexture) -> Any:
        """Return the bind group of a picture, which stays the same from frame to frame."""
        if self._copied[0] is not picture.storage_view:
            group = self._recorder.device.create_bind_group(
                layout=self._pipeline.get_bind_group_layout(0),
                entries=[{"binding": 0, "resource": picture.storage_view}],
            )
            self._copied = picture.storage_view, group
        return self._copied[1]

    def release(self) -> None:
        """Give the surface back, which must happen before its window closes."""
        if self._context is not None:
            self._context.unconfigure()
            self._context, self._copied = None, (None, None)


def _plain_format(context: Any, adapter: Any) -> str:
    """Return a format of the surface that takes display values as they are."""
    formats: list[str] = context._get_capabilities(adapter)["formats"]
    return next((one for one in formats if one.endswith("8unorm")), formats[0])
