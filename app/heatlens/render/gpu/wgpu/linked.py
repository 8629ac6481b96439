"""What a program of wgpu takes by name, and what is bound to it.

A program with images that declare no format is built once for each combination of formats that it
is given.
"""

import os
import re
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import wgpu

from heatlens.core.base.errors import ShaderError
from heatlens.render.gpu.device import DeviceError
from heatlens.render.gpu.linked_program import LinkedProgram, NamedBuffers, NamedImages, Uniforms
from heatlens.render.gpu.resources import Buffer, BufferPart, Sampling, StorageBuffer
from heatlens.render.gpu.shader_source import ShaderSource, Stage, declared_in
from heatlens.render.gpu.wgpu.buffers import WgBuffer
from heatlens.render.gpu.wgpu.framebuffers import DrawState
from heatlens.render.gpu.wgpu.recorder import Recorder
from heatlens.render.gpu.wgpu.reflection import Binding, Reflection, Uniform, reflect
from heatlens.render.gpu.wgpu.spirv import compile_stages
from heatlens.render.gpu.wgpu.stand_ins import StandIns
from heatlens.render.gpu.wgpu.translation import (
    comparing_samplers,
    formatless_images,
    translate_stages,
)

STRICT_VARIABLE = "HEATLENS_STRICT_SHADERS"
_GROUPS_KEPT = 64  # bind groups of a program that are kept
_NOTHING: Mapping[str, Any] = {}
_PLACE = re.compile(r"program\.(comp|vert|frag):(\d+)")  # in the compiler's log
_VISIBLE = {
    "comp": wgpu.ShaderStage.COMPUTE,
    "vert": wgpu.ShaderStage.VERTEX,
    "frag": wgpu.ShaderStage.FRAGMENT,
}


class Shared:
    """What all programs of a device share."""

    def __init__(self, recorder: Recorder) -> None:
        self.recorder, self.device = recorder, recorder.device
        self.stand_ins = StandIns(recorder)
        self.draw_state = DrawState()
        self._samplers: dict[tuple[Sampling, bool, bool], Any] = {}

    def sampler(self, sampling: Sampling, repeats: bool, compares: bool) -> Any:
        """Return the sampler of a texture."""
        key = sampling, repeats, compares
        if key not in self._samplers:
            mode = "repeat" if repeats else "clamp-to-edge"
            linear = "nearest" if sampling is Sampling.NEAREST else "linear"
            words: dict[str, Any] = {"compare": "less-equal"} if compares else {}
            words |= {f"address_mode_{axis}": mode for axis in "uvw"}
            words |= {"mag_filter": linear, "min_filter": linear}
            words["mipmap_filter"] = "linear" if sampling is Sampling.MIPMAPPED else "nearest"
            if sampling is not Sampling.MIPMAPPED:
                words["lod_max_clamp"] = 0.0
            self._samplers[key] = self.device.create_sampler(**words)
        return self._samplers[key]


@dataclass
class Variant:
    """A program that is built for some formats of its images.

    modules  of the stages; layout of the bind group
    """

    modules: Mapping[Stage, Any]
    bindings: Sequence[Binding]
    uniforms: Mapping[str, Uniform]
    block_bytes: int
    inputs: Mapping[str, int]
    group_layout: Any
    layout: Any


class WgProgram(LinkedProgram):
    """The inputs of a program, and the bind groups that were made for them.

    shared   what all programs of the device share
    buffers  the storage blocks of the next run, by name
    """

    def __init__(self, shared: Shared, sources: Mapping[Stage, ShaderSource]) -> None:
        self.shared, self._sources = shared, sources
        self._declared = declared_in(list(sources.values()))
        self._name = " and ".join(self._declared.files)
        texts = list(sources.values())
        self._formatless = [n for one in texts for n in formatless_images(one)]
        self._compared = comparing_samplers(texts)
        self._variants: dict[tuple[str, ...], Variant] = {}
        self._groups: OrderedDict[tuple[object, ...], Any] = OrderedDict()
        self._is_strict = bool(os.environ.get(STRICT_VARIABLE))
        self._values: dict[str, object] = {}
        self._textures: Mapping[str, Any] = _NOTHING
        self._images: Mapping[str, Any] = _NOTHING
        self.buffers: Mapping[str, Any] = _NOTHING
        self._variant(
            ("rgba16float",) * len(self._formatless)
        )  # tells mistakes in the text at once

    def bind(
        self, textures: NamedImages, images: NamedImages, buffers: NamedBuffers, uniforms: Uniforms
    ) -> None:
        """Keep the inputs and outputs of the next run, by name.

        Raises ShaderError for a name that the program does not declare.
        """
        self._textures, self._images = textures or _NOTHING, images or _NOTHING
        self.buffers = buffers or _NOTHING
        if self._is_strict:
            self._check_names(uniforms or _NOTHING)
        for name, value in (uniforms or _NOTHING).items():
            self._declared.check(name, "uniform")
            self._values[name] = value

    def _check_names(self, uniforms: Mapping[str, object]) -> None:
        """Raise ShaderError for a name that is not declared as what it is given for."""
        for name in self._textures:
            self._declared.check(name, "sampler")
        for name in self._images:
            self._declared.check(name, "image")
        for name in self.buffers:
            self._declared.check(name, "storage block")

    def variant(self) -> Variant:
        """Return the program for the formats of the images that are bound."""
        return self._variant(tuple(self._images[name].format for name in self._formatless))

    def _variant(self, formats: tuple[str, ...]) -> Variant:
        """Return the program for these formats, built on first use."""
        if formats not in self._variants:
            names = zip(self._formatless, formats, strict=True)
            self._variants[formats] = self._build({name: _glsl_format(one) for name, one in names})
        return self._variants[formats]

    def _build(self, formats: Mapping[str, str]) -> Variant:
        """Compile the stages, and find out what they take."""
        stages = translate_stages(self._sources, formats)
        try:
            compiled = compile_stages(stages)
        except ShaderError as error:
            raise ShaderError(self._explained(str(error))) from None
        device, reflections = self.shared.device, [reflect(module) for module in compiled]
        try:
            modules = {
                one.stage: device.create_shader_module(code=module)
                for one, module in zip(stages, compiled, strict=True)
            }
        except DeviceError as error:
            raise ShaderError(f"{self._name}: {error.details}") from error
        entries = self._layout_entries([one.stage for one in stages], reflections)
        group_layout = device.create_bind_group_layout(entries=entries)
        first = reflections[0]
        return Variant(
            modules,
            list({one.number: one for it in reflections for one in it.bindings}.values()),
            {name: one for it in reflections for name, one in it.uniforms.items()},
            max(it.block_bytes for it in reflections),
            first.inputs,
            group_layout,
            device.create_pipeline_layout(bind_group_layouts=[group_layout]),
        )

    def _explained(self, log: str) -> str:
        """Return the compiler's log with places as file and line, and the refused file before."""
        sources = {str(stage): source for stage, source in self._sources.items()}
        place = _PLACE.search(log)
        refused = sources[place[1]].files[0] if place else self._name
        explained = _PLACE.sub(lambda it: sources[it[1]].explain_log(f"0:{it[2]}"), log)
        return f"{refused}: {explained}"

    def _layout_entries(
        self, stages: Sequence[Stage], reflections: Sequence[Reflection]
    ) -> list[dict[str, Any]]:
        """Return the layout of the bind group that all stages share."""
        entries: dict[int, dict[str, Any]] = {}
        for stage, reflection in zip(stages, reflections, strict=True):
            for one in reflection.bindings:
                entry = entries.setdefault(one.number, {"binding": one.number, "visibility": 0})
                entry["visibility"] |= _VISIBLE[stage]
                entry |= self._resource_layout(one)
        return list(entries.values())

    def _resource_layout(self, one: Binding) -> dict[str, Any]:
        """Return what the layout of the bind group says of one resource."""
        compares = one.name in self._compared
        if one.kind == "sampler":
            return {"sampler": {"type": "comparison"} if compares else one.layout}
        if one.kind == "texture":
            return {"texture": one.layout | ({"sample_type": "depth"} if compares else {})}
        if one.kind == "image":
            return {"storage_texture": one.layout}
        return {"buffer": one.layout}

    def group(self, variant: Variant) -> Any:
        """Return the bind group of what is bound, made on first use."""
        resources = [(one, self._resource(one, variant)) for one in variant.bindings]
        key = tuple(
            value if not isinstance(value, dict) else (value["buffer"], value["offset"])
            for _, value in resources
        )
        if key not in self._groups:
            entries = [{"binding": one.number, "resource": value} for one, value in resources]
            self._groups[key] = self.shared.device.create_bind_group(
                layout=variant.group_layout, entries=entries
            )
            if len(self._groups) > _GROUPS_KEPT:
                self._groups.popitem(last=False)
        self._groups.move_to_end(key)
        return self._groups[key]

    def _resource(self, one: Binding, variant: Variant) -> Any:
        """Return what is bound to one binding, or a stand-in where nothing was given."""
        if one.kind == "uniforms":
            size = variant.block_bytes
            return {"buffer": self.shared.recorder.uniforms, "offset": 0, "size": size}
        if one.kind == "storage":
            return self._buffer(one.name)
        if one.kind == "image":
            image = self._images.get(one.name)
            return self.shared.stand_ins.image(one.layout) if image is None else image.storage_view
        texture = self._textures.get(one.name)
        if one.kind == "texture":
            return self._sampled(one, texture)
        compares = one.name in self._compared
        if texture is None:
            return self.shared.sampler(Sampling.NEAREST, False, compares)
        return self.shared.sampler(texture.sampling, texture.repeats, compares)

    def _sampled(self, one: Binding, texture: Any) -> Any:
        """Return the view of a texture, or of a copy where the program also writes the texture.

        wgpu refuses a texture that is sampled and written at once. A program that does so reads of
        it what was there before.
        """
        stand_ins = self.shared.stand_ins
        if texture is None:
            return stand_ins.texture(one.layout)
        is_written = any(image is texture for image in self._images.values())
        return stand_ins.copy_of(one.name, texture) if is_written else texture.view

    def _buffer(self, name: str) -> dict[str, Any]:
        """Return the buffer of a storage block, or the part of one."""
        given = self.buffers.get(name)
        if given is None:
            raw = self.shared.stand_ins.buffer()
            return {"buffer": raw, "offset": 0, "size": raw.size}
        if isinstance(given, BufferPart):
            return {"buffer": wg_buffer(given.whole), "offset": given.first, "size": given.size}
        raw = wg_buffer(given)  # whose memory is larger; the shader sees the length that was asked
        size = -(-given.size // 4) * 4 if given.size > 16 else raw.size
        return {"buffer": raw, "offset": 0, "size": size}

    def place(self, variant: Variant) -> list[int]:
        """Keep the values of the uniforms. Return the offset of the block, if there is one."""
        if not variant.block_bytes:
            return []
        block = bytearray(variant.block_bytes)
        for name, uniform in variant.uniforms.items():
            if name in self._values:
                uniform.write(block, self._values[name])
        return [self.shared.recorder.place_of(block)]

    def release(self) -> None:
        self._groups.clear()
        self._variants.clear()


def _glsl_format(format_: str) -> str:
    """Return the name in GLSL of a format of wgpu, such as rgba16f and rgba8."""
    return format_.removesuffix("unorm").removesuffix("loat")


def whole_buffer(buffer: StorageBuffer) -> Buffer:
    """Return a buffer, or the one that it is a part of."""
    return buffer.whole if isinstance(buffer, BufferPart) else buffer


def wg_buffer(buffer: Buffer) -> Any:
    """Return the buffer of wgpu that a buffer of this device wraps."""
    assert isinstance(buffer, WgBuffer)
    return buffer.raw
