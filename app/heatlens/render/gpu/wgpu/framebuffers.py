"""Framebuffers of wgpu, and the state with which the next draws go into one."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import wgpu

from heatlens.render.gpu.framebuffer import Blend, DepthTest, Framebuffer
from heatlens.render.gpu.resources import Area, Data, DepthBuffer, Texture
from heatlens.render.gpu.wgpu.area_clear import AreaClear
from heatlens.render.gpu.wgpu.recorder import Recorder
from heatlens.render.gpu.wgpu.textures import DEPTH_FORMAT, bytes_of


def _sum_of(source: str, target: str) -> dict[str, str]:
    """Return the sum of what is drawn and what is there, each times a factor."""
    return {"operation": "add", "src_factor": source, "dst_factor": target}


# Straight alpha over the content below; the alpha of the framebuffer stays.
BLENDS = {
    Blend.ADD: {"color": _sum_of("one", "one"), "alpha": _sum_of("one", "one")},
    Blend.OVER: {
        "color": _sum_of("src-alpha", "one-minus-src-alpha"),
        "alpha": _sum_of("zero", "one"),
    },
}
_COMPARISONS = {
    DepthTest.NONE: "always",
    DepthTest.LESS: "less",
    DepthTest.EQUAL: "equal",
    DepthTest.AT_MOST: "less-equal",
    DepthTest.ALWAYS: "always",
}


class DrawState:
    """The framebuffer in use, and how draws blend and compare depths."""

    def __init__(self) -> None:
        self.target: WgFramebuffer | None = None
        self.blend, self.depth = Blend.NONE, DepthTest.NONE

    def begin(self, recorder: Recorder) -> Any:
        """Return a render pass into the framebuffer, which draws that follow each other share."""
        return recorder.render_pass(self._target, self._target.attachments())

    def pipeline_key(self) -> tuple[object, ...]:
        """Return what a pipeline depends on."""
        target = self._target
        formats = tuple(one.format for one in target.textures)
        has_depth = target.depth is not None
        writes = target.writes_color, target.writes_depth
        return formats, has_depth, self.blend, self.depth, writes

    def targets(self) -> list[dict[str, Any]]:
        """Return the colors that a pipeline writes."""
        mask = wgpu.ColorWrite.ALL if self._target.writes_color else 0
        blend = {} if self.blend is Blend.NONE else {"blend": BLENDS[self.blend]}
        return [
            {"format": one.format, "write_mask": mask, **blend} for one in self._target.textures
        ]

    def depth_stencil(self) -> dict[str, Any] | None:
        """Return how a pipeline compares and writes depths."""
        if self._target.depth is None:
            return None
        writes = self.depth is not DepthTest.NONE and self._target.writes_depth
        return {
            "format": DEPTH_FORMAT,
            "depth_write_enabled": writes,
            "depth_compare": _COMPARISONS[self.depth],
        }

    def set_area(self, draw: Any) -> None:
        """Limit a render pass to the viewport and the scissor of the framebuffer."""
        target = self._target
        draw.set_viewport(*target.viewport, 0.0, 1.0)
        draw.set_scissor_rect(*area_inside(target.scissor or (0, 0, *target.size), target.size))

    @property
    def _target(self) -> "WgFramebuffer":
        assert self.target is not None, "no framebuffer is in use"
        return self.target


def area_inside(area: Area, size: tuple[int, int]) -> Area:
    """Return the part of an area that lies inside a framebuffer."""
    x, y = (min(max(0, at), side) for at, side in zip(area[:2], size, strict=True))
    width, height = (
        max(0, min(at + extent, side) - begin)
        for at, extent, side, begin in zip(area[:2], area[2:], size, (x, y), strict=True)
    )
    return x, y, width, height


class WgFramebuffer(Framebuffer):
    """Textures of wgpu that draws write into."""

    def __init__(
        self,
        recorder: Recorder,
        state: DrawState,
        area_clear: AreaClear,
        colors: Sequence[Texture],
        depth: DepthBuffer | Texture | None,
    ) -> None:
        self._recorder, self._state, self._area_clear = recorder, state, area_clear
        self.textures: list[Any] = list(colors)
        self.depth: Any = depth
        self.color_attachments = tuple(colors)
        first: Any = colors[0] if colors else depth
        self.size = first.size[:2]
        self.viewport: Area = (0, 0, *self.size)
        self.scissor: Area | None = None
        self.writes_color = self.writes_depth = True

    def use(self) -> None:
        self._state.target = self

    def clear(
        self, red: float = 0.0, green: float = 0.0, blue: float = 0.0, alpha: float = 0.0
    ) -> None:
        color = (red, green, blue, alpha)
        if self.scissor is not None and area_inside(self.scissor, self.size)[2:] != self.size:
            self._clear_area(area_inside(self.scissor, self.size), color)
            return
        self._recorder.encoder()  # a render pass that is open does not begin with a color
        self._recorder.render_pass(self, self.attachments(clear=color))

    def attachments(self, clear: Sequence[float] | None = None) -> dict[str, Any]:
        """Return what a render pass into it takes; `clear` is a color to begin with."""
        op = "load" if clear is None else "clear"
        color = clear or (0.0, 0.0, 0.0, 0.0)
        words: dict[str, Any] = {
            "color_attachments": [
                {"view": one.storage_view, "load_op": op, "store_op": "store", "clear_value": color}
                for one in self.textures
            ]
        }
        if self.depth is not None:
            words["depth_stencil_attachment"] = {
                "view": self.depth.storage_view,
                "depth_load_op": op,
                "depth_store_op": "store",
                "depth_clear_value": 1.0,
            }
        return words

    def _clear_area(self, area: Area, color: tuple[float, ...]) -> None:
        """Fill a part with a color, and its depths with the farthest."""
        place = self._area_clear.place_of(color)
        formats = tuple(one.format for one in self.textures)
        draw = self._recorder.render_pass(self, self.attachments())
        draw.set_viewport(0, 0, *self.size, 0.0, 1.0)
        draw.set_scissor_rect(*area)
        self._area_clear.draw(draw, formats, DEPTH_FORMAT if self.depth else "", place)

    def read(self, viewport: Area | None = None, components: int = 3, dtype: str = "f1") -> bytes:
        texture, area = self.textures[0], area_inside(viewport or (0, 0, *self.size), self.size)
        if not min(area[2:]):
            return b""
        with texture.texels(area) as texels:
            pixels = texels[..., :components]
            if dtype == "f1" and texture.dtype != "f1":
                pixels = np.rint(np.clip(pixels, 0.0, 1.0) * 255).astype(np.uint8)
            elif dtype == "f4":
                pixels = pixels.astype(np.float32) / (255 if texture.dtype == "f1" else 1)
            return bytes(pixels.tobytes())

    def read_into(self, data: Data, components: int = 3) -> None:
        bytes_of(data)[:] = self.read(components=components)

    def release(self) -> None:
        if self._state.target is self:
            self._state.target = None
