"""A device that claims to be a GPU, and counts what it is asked for instead of doing the work."""

from collections import Counter
from collections.abc import Callable, Iterator
from copy import copy
from typing import TypeVar

import moderngl

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.opengl.gl_device import GlDevice
from heatlens.render.gpu.opengl.programs import Linked

T = TypeVar("T")

COUNTED_NAME = "a GPU that is counted for"


def counting_device(device: Device, counts: Counter[str]) -> Device:
    """Return a stand-in for `device` that builds and binds everything, but runs and draws nothing.

    It counts each dispatch, indirect dispatch, draw, clear, barrier and uniform that is set.
    """
    assert isinstance(device, GlDevice)
    made = GlDevice(_counting(device.raw, counts))
    made.name, made.is_software = COUNTED_NAME, False
    return made


def _counting(ctx: moderngl.Context, counts: Counter[str]) -> moderngl.Context:
    counting = copy(ctx)

    def compute_shader(source: str) -> object:
        return _Program(ctx.compute_shader(source), counts)

    def program(vertex_shader: str, fragment_shader: str) -> object:
        linked = ctx.program(vertex_shader=vertex_shader, fragment_shader=fragment_shader)
        return _Program(linked, counts)

    def vertex_array(linked: _Program, *content: object, skip_errors: bool) -> object:
        made = ctx.vertex_array(linked.linked, *content, skip_errors=skip_errors)
        return _without(made, ("render", "render_indirect"), _counter(counts, "draw"))

    def framebuffer(
        colors: object, depth: moderngl.Renderbuffer | moderngl.Texture | None
    ) -> object:
        return _without(ctx.framebuffer(colors, depth), ("clear",), _counter(counts, "clear"))

    for made in (compute_shader, program, vertex_array, framebuffer):
        setattr(counting, made.__name__, made)
    return _without(counting, ("memory_barrier",), _counter(counts, "barrier"))


def _without(made: T, names: tuple[str, ...], instead: Callable[..., None]) -> T:
    """Return an object of moderngl that does something else in place of these methods."""
    for name in names:
        setattr(made, name, instead)
    return made


def _counter(counts: Counter[str], kind: str) -> Callable[..., None]:
    def count(*args: object, **options: object) -> None:
        counts[kind] += 1

    return count


class _Program:
    """A linked program that only counts its runs and the uniforms that are set."""

    def __init__(self, linked: Linked, counts: Counter[str]) -> None:
        self.linked, self._counts = linked, counts
        self.run, self.run_indirect = _counter(counts, "dispatch"), _counter(counts, "indirect")

    def __iter__(self) -> Iterator[str]:
        return iter(self.linked)

    def __getitem__(self, name: str) -> object:
        return self.linked[name]

    def __setitem__(self, name: str, value: object) -> None:
        self._counts["uniform"] += 1
        self.linked[name] = value

    def release(self) -> None:
        self.linked.release()
