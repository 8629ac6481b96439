"""A device that claims to be a GPU, and counts the calls for work instead of doing it."""

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
    stand_in = GlDevice(_counting_context(device.raw, counts))
    stand_in.name, stand_in.is_software = COUNTED_NAME, False
    return stand_in


def _counting_context(ctx: moderngl.Context, counts: Counter[str]) -> moderngl.Context:
    """Return a copy of a context whose programs, draws, clears and barriers only add to `counts`.

    Programs, vertex arrays and framebuffers are still built by the original context.
    """
    copied = copy(ctx)

    def compute_shader(source: str) -> object:
        return _Program(ctx.compute_shader(source), counts)

    def program(vertex_shader: str, fragment_shader: str) -> object:
        linked = ctx.program(vertex_shader=vertex_shader, fragment_shader=fragment_shader)
        return _Program(linked, counts)

    def vertex_array(linked: _Program, *content: object, skip_errors: bool) -> object:
        array = ctx.vertex_array(linked.linked, *content, skip_errors=skip_errors)
        return _replace_methods(array, ("render", "render_indirect"), _counter(counts, "draw"))

    def framebuffer(
        colors: object, depth: moderngl.Renderbuffer | moderngl.Texture | None
    ) -> object:
        """Return a framebuffer that counts its clears."""
        return _replace_methods(
            ctx.framebuffer(colors, depth), ("clear",), _counter(counts, "clear")
        )

    for function in (compute_shader, program, vertex_array, framebuffer):
        setattr(copied, function.__name__, function)
    return _replace_methods(copied, ("memory_barrier",), _counter(counts, "barrier"))


def _replace_methods(raw_object: T, names: tuple[str, ...], replacement: Callable[..., None]) -> T:
    """Replace methods of an object of moderngl by one function, and return the object."""
    for name in names:
        setattr(raw_object, name, replacement)
    return raw_object


def _counter(counts: Counter[str], kind: str) -> Callable[..., None]:
    """Return a function that adds 1 to `counts[kind]` and ignores its arguments."""

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
