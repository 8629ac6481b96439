"""A device that claims to be a GPU, and counts what it is asked for instead of doing the work."""

from collections import Counter
from collections.abc import Callable
from copy import copy
from typing import Any

from heatlens.gpu.device import Device
from heatlens.gpu.opengl.gl_device import GlDevice

COUNTED_NAME = "a GPU that is counted for"


def counting_device(device: Device, counts: Counter[str]) -> Device:
    """Return a stand-in for `device` that builds and binds everything, but runs and draws nothing.

    It counts each dispatch, indirect dispatch, draw, clear, barrier and uniform that is set.
    """
    assert isinstance(device, GlDevice)
    made = GlDevice(_counting(device.raw, counts))
    made.name, made.is_software = COUNTED_NAME, False
    return made


def _counting(ctx: Any, counts: Counter[str]) -> Any:
    counting = copy(ctx)

    def compute_shader(source: str) -> object:
        return _Program(ctx.compute_shader(source), counts)

    def program(**shaders: Any) -> object:
        return _Program(ctx.program(**shaders), counts)

    def vertex_array(linked: _Program, *args: Any, **options: Any) -> object:
        made = ctx.vertex_array(linked.linked, *args, **options)
        made.render = made.render_indirect = _counter(counts, "draw")
        return made

    def framebuffer(*args: Any, **options: Any) -> object:
        made = ctx.framebuffer(*args, **options)
        made.clear = _counter(counts, "clear")
        return made

    for made in (compute_shader, program, vertex_array, framebuffer):
        setattr(counting, made.__name__, made)
    counting.memory_barrier = _counter(counts, "barrier")
    return counting


def _counter(counts: Counter[str], kind: str) -> Callable[..., None]:
    def count(*args: object, **options: object) -> None:
        counts[kind] += 1

    return count


class _Program:
    """A linked program that only counts its runs and the uniforms that are set."""

    def __init__(self, linked: Any, counts: Counter[str]) -> None:
        self.linked, self._counts = linked, counts
        self.run, self.run_indirect = _counter(counts, "dispatch"), _counter(counts, "indirect")

    def __iter__(self) -> Any:
        return iter(self.linked)

    def __getitem__(self, name: str) -> Any:
        return self.linked[name]

    def __setitem__(self, name: str, value: object) -> None:
        self._counts["uniform"] += 1
        self.linked[name] = value

    def release(self) -> None:
        self.linked.release()
