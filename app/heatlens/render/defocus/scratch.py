"""Manage the memory that passes share, by the passes between which it is used.

Every texture and buffer has its own name. The passes declare who writes it first and who reads it
last (`render/defocus/pass_list.py`); names with separate lifetimes can share memory. The pipeline
announces the end of each pass (`Scratch.end_pass`); a second owner at the same time raises an
error. With HEATLENS_POISON_SCRATCH=1 in the environment, memory is filled with NaN at the end of
its lifetime, which makes a pass that still reads it visible in the picture.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

from heatlens.core.base.memory import give_back_freed_memory
from heatlens.render.defocus import pass_list
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Buffer, Texture, TextureArray
from heatlens.render.gpu.textures import BufferParts, Storage, TexturePool

POISON_VARIABLE = "HEATLENS_POISON_SCRATCH"

AFTER_THE_PICTURE = ""  # stands for no pass: the memory is used until the next picture


@dataclass(frozen=True)
class Lifetime:
    """The lifetime of a name: from the pass that writes it first to the one that reads it last.

    `memory` is the name of the memory.
    """

    memory: str
    first: str
    last: str


def lifetimes() -> dict[str, Lifetime]:
    """Return the lifetime of each texture and buffer by its name, as the passes declare it."""
    passes, by_name = pass_list.PASSES, {}
    last_readers = {
        name: render_pass.name for render_pass in passes for name in render_pass.reads_last
    }
    for render_pass in passes:
        for name, memory in (*render_pass.writes.items(), *render_pass.private_memory.items()):
            last_pass = (
                render_pass.name
                if name in render_pass.private_memory
                else last_readers.get(name, AFTER_THE_PICTURE)
            )
            by_name[name] = Lifetime(memory=memory or name, first=render_pass.name, last=last_pass)
    return by_name


_AnyMemory = Texture | TextureArray | Buffer
MemoryType = TypeVar("MemoryType", Texture, TextureArray, Buffer)


class Scratch:
    """The textures and buffers of one pipeline by the names that the passes declare."""

    def __init__(self, ctx: Device) -> None:
        self._pool = TexturePool(ctx)
        self._owned: dict[str, tuple[str, _AnyMemory]] = {}  # memory by name, with its owner
        self._lifetimes = lifetimes()
        self._poisons = bool(os.environ.get(POISON_VARIABLE))

    def begin_picture(self) -> None:
        """End all lifetimes, because the last picture may not have been finished."""
        self._owned.clear()

    def texture(
        self, name: str, size: tuple[int, int], components: int, storage: Storage = "f4"
    ) -> Texture:
        """Return the texture called `name`, with its previous content.

        A pixel has 1 to 4 `components` of the type `storage`. Raises RuntimeError if the memory
        still belongs to another name.
        """
        memory = self._lifetimes[name].memory
        return self._lend_memory(
            name, memory, self._pool.texture(memory, size, components, storage)
        )

    def array(
        self,
        name: str,
        size: tuple[int, int],
        layers: int,
        components: int,
        storage: Storage = "f4",
    ) -> TextureArray:
        """Return the texture array called `name`, with `layers` layers and its previous content.

        Raises RuntimeError if the memory still belongs to another name.
        """
        memory = self._lifetimes[name].memory
        texture_array = self._pool.array(memory, size, layers, components, storage)
        return self._lend_memory(name, memory, texture_array)

    def buffer(self, name: str, size_bytes: int) -> Buffer:
        """Return the storage buffer called `name`, of at least `size_bytes`.

        Raises RuntimeError if the memory still belongs to another name.
        """
        memory = self._lifetimes[name].memory
        return self._lend_memory(name, memory, self._pool.buffer(memory, size_bytes))

    def kept_texture(self, name: str) -> Texture | None:
        """Return a texture of the latest picture that lives until the next; None if it has none."""
        texture = self._owned.get(self._lifetimes[name].memory, (name, None))[1]
        return texture if isinstance(texture, Texture) else None

    def parts(self, name: str, count: int, least_bytes: int) -> BufferParts:
        """Return the storage buffer called `name` as `count` parts of at least `least_bytes`."""
        part_bytes = BufferParts.bytes_for(least_bytes)
        return BufferParts(self.buffer(name, count * part_bytes), part_bytes)

    def end_pass(self, name: str) -> str:
        """Free all memory that the pass `name` was the last to read.

        Return the name, which the caller can yield as that of a step.
        """
        for memory, (owner, resource) in list(self._owned.items()):
            if self._lifetimes[owner].last == name:
                del self._owned[memory]
                if self._poisons:
                    _poison(resource)
        return name

    def run_pass(self, name: str, steps: Iterator[None]) -> Iterator[str]:
        """Yield the name for each step of a pass; the pass has ended after the last one."""
        for _ in steps:
            yield name
        self.end_pass(name)

    def release_unowned(self) -> None:
        """Release the memory whose lifetimes have ended, before passes that need other memory."""
        self._pool.release(kept=self._owned)
        give_back_freed_memory()

    def release(self) -> None:
        """Release all memory."""
        self._owned.clear()
        self._pool.release()

    # A second owner is an error, because with a wrong lifetime in the table a pass would overwrite
    # data that another pass still reads. Poisoned memory shows a pass that reads too late. With
    # shared memory, a film picture of 1920x1080 needs 184 bytes per pixel.
    def _lend_memory(self, name: str, memory: str, resource: MemoryType) -> MemoryType:
        """Record `name` as the owner of `memory`. Raises RuntimeError if another still owns it."""
        owner = self._owned.get(memory, (name, resource))[0]
        if owner != name:
            raise RuntimeError(
                f"The memory '{memory}' still belongs to '{owner}', not to '{name}'."
            )
        self._owned[memory] = name, resource
        return resource


def _poison(resource: _AnyMemory) -> None:
    """Fill a texture or buffer with NaN."""
    resource.fill_with_nan()
