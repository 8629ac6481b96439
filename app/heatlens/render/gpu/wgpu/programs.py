"""Programs of wgpu that compute and that draw."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

from heatlens.render.gpu.framebuffer import Primitive
from heatlens.render.gpu.linked_program import LinkedArray, LinkedCompute, LinkedDraw, VertexLayout
from heatlens.render.gpu.resources import Buffer
from heatlens.render.gpu.shader_source import ShaderSource
from heatlens.render.gpu.wgpu.linked import Shared, Variant, WgProgram, wg_buffer, whole_buffer
from heatlens.render.gpu.wgpu.vertices import VertexInputs

_TOPOLOGIES = {Primitive.TRIANGLES: "triangle-list", Primitive.TRIANGLE_STRIP: "triangle-strip"}


class WgCompute(WgProgram, LinkedCompute):
    """A compute program of wgpu."""

    def __init__(self, shared: Shared, source: ShaderSource) -> None:
        self._pipelines: dict[int, Any] = {}
        super().__init__(shared, {"comp": source})

    def run(self, groups: tuple[int, ...]) -> None:
        if all(groups):
            self._ready_pass().dispatch_workgroups(*groups)

    def run_indirect(self, groups: Buffer, offset: int) -> None:
        raw = wg_buffer(groups)
        if any(wg_buffer(whole_buffer(one)) is raw for one in self.buffers.values()):
            # wgpu refuses a buffer of counts that the program itself may write
            counts = self.shared.stand_ins.counts()
            self.shared.recorder.encoder().copy_buffer_to_buffer(raw, offset, counts, 0, 12)
            raw, offset = counts, 0
        self._ready_pass().dispatch_workgroups_indirect(raw, offset)

    def _ready_pass(self) -> Any:
        """Return a compute pass in which everything is set."""
        variant = self.variant()
        place, group = self.place(variant), self.group(variant)
        compute = self.shared.recorder.compute_pass()
        compute.set_pipeline(self._pipeline(variant))
        compute.set_bind_group(0, group, place)
        return compute

    def _pipeline(self, variant: Variant) -> Any:
        """Return the pipeline of a variant, made on first use."""
        if id(variant) not in self._pipelines:
            self._pipelines[id(variant)] = self.shared.recorder.build_pipeline(
                self.shared.device.create_compute_pipeline,
                layout=variant.layout,
                compute={"module": variant.modules["comp"], "entry_point": "main"},
            )
        return self._pipelines[id(variant)]


class WgDraw(WgProgram, LinkedDraw):
    """A program of wgpu that draws vertices."""

    def __init__(self, shared: Shared, vertex: ShaderSource, fragment: ShaderSource) -> None:
        self._pipelines: dict[tuple[object, ...], Any] = {}
        super().__init__(shared, {"vert": vertex, "frag": fragment})

    @cached_property
    def inputs(self) -> Mapping[str, int]:
        """The locations of the attributes that the program uses."""
        return self.variant().inputs

    def vertex_array(self, layout: VertexLayout, index: Buffer | None) -> LinkedArray:
        return WgArray(self, VertexInputs(layout, self.inputs), index)

    def ready_pass(self, mode: Primitive, vertices: VertexInputs) -> Any:
        """Return a render pass into the framebuffer in use, in which everything is set."""
        variant, state = self.variant(), self.shared.draw_state
        place, group = self.place(variant), self.group(variant)
        draw = state.begin(self.shared.recorder)
        draw.set_pipeline(self._pipeline(variant, mode, vertices))
        draw.set_bind_group(0, group, place)
        state.set_area(draw)
        for slot, buffer in enumerate(vertices.buffers):
            draw.set_vertex_buffer(slot, wg_buffer(buffer))
        return draw

    def _pipeline(self, variant: Variant, mode: Primitive, vertices: VertexInputs) -> Any:
        """Return the pipeline for the state of the draw, made on first use."""
        state = self.shared.draw_state
        key = id(variant), mode, vertices.key, state.pipeline_key()
        if key not in self._pipelines:
            self._pipelines[key] = self.shared.recorder.build_pipeline(
                self.shared.device.create_render_pipeline,
                layout=variant.layout,
                vertex={
                    "module": variant.modules["vert"],
                    "entry_point": "main",
                    "buffers": vertices.layouts,
                },
                fragment={
                    "module": variant.modules["frag"],
                    "entry_point": "main",
                    "targets": state.targets(),
                },
                # what turns anticlockwise in OpenGL turns the other way with y reversed
                primitive={"topology": _TOPOLOGIES[mode], "front_face": "cw"},
                depth_stencil=state.depth_stencil(),
            )
        return self._pipelines[key]


class WgArray(LinkedArray):
    """Buffers as the vertices of a draw program."""

    def __init__(self, program: WgDraw, vertices: VertexInputs, index: Buffer | None) -> None:
        self._program, self._vertices, self._index = program, vertices, index

    def render(self, mode: Primitive, vertices: int) -> None:
        draw = self._program.ready_pass(mode, self._vertices)
        draw.draw(vertices, self._vertices.instances)

    def render_indirect(self, commands: Buffer, mode: Primitive, count: int) -> None:
        draw, raw = self._program.ready_pass(mode, self._vertices), wg_buffer(commands)
        if self._index is None:
            for number in range(count):
                draw.draw_indirect(raw, 16 * number)
            return
        draw.set_index_buffer(wg_buffer(self._index), "uint32")
        for number in range(count):
            draw.draw_indexed_indirect(raw, 20 * number)

    def release(self) -> None:
        """Delete it, but not the buffers."""
