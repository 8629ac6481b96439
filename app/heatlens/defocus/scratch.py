"""Manage the memory that passes share, by the passes between which it is used.

Every texture and buffer has its own name. `LIFETIMES` has the pass that writes it first and the
pass that reads it last; names with separate lifetimes can share memory. The pipeline announces the
end of each pass (`Scratch.passed`), so that a second owner at the same time raises an error. With
HEATLENS_POISON_SCRATCH=1 in the environment, memory is filled with NaN at the end of its lifetime,
which makes a pass that still reads it visible in the picture.
"""

import os
from dataclasses import dataclass
from typing import TypeVar

import moderngl

from heatlens.gpu.nan_fill import fill_buffer, fill_texture
from heatlens.gpu.textures import Storage, TexturePool

POISON_VARIABLE = "HEATLENS_POISON_SCRATCH"

# The passes in their order. "tiles" to "composite" run once for each layer.
PASSES = (
    *("proxy", "coc", "alpha", "highlights found", "highlights listed", "fragments", "tiles"),
    *("layer split", "hidden fill", "coc fill", "blur", "composite", "highlights drawn", "limits"),
    *("colours",),  # after all passes before it, for each colour
    *("gather", "scatter", "pyramid"),  # each replaces "alpha" to "highlights drawn"
)
AFTER_THE_PICTURE = ""  # stands for no pass: the memory is used until the next picture


@dataclass(frozen=True)
class Lifetime:
    """The lifetime of a name: from the pass that writes it first to the one that reads it last.

    `memory` is the name of the memory. Layers have separate memory for each reduction; `reduction`
    is set if the name is used for one reduction only.
    """

    memory: str
    first: str
    last: str
    reduction: int | None = None

    def meets(self, other: "Lifetime") -> bool:
        """Return True if both use the same memory at the same time."""
        sizes = {self.reduction, other.reduction}
        if self.memory != other.memory or (None not in sizes and len(sizes) == 2):
            return False
        return _place(self.first) <= _place(other.last) and _place(other.first) <= _place(self.last)


def _place(name: str) -> int:
    return PASSES.index(name) if name else len(PASSES)


_KEPT = AFTER_THE_PICTURE
LIFETIMES: dict[str, Lifetime] = {
    # The plate as it is worked on, and the results.
    "proxy colour": Lifetime("proxy colour", "proxy", _KEPT),
    "proxy depth": Lifetime("proxy depth", "proxy", _KEPT),
    "proxy starts": Lifetime("proxy starts", "proxy", _KEPT),
    "proxy fragments": Lifetime("proxy fragments", "proxy", _KEPT),
    "proxy fragment count": Lifetime("proxy fragment count", "proxy", _KEPT),
    "wide colour": Lifetime("wide colour", "proxy", _KEPT),
    "wide depth": Lifetime("wide depth", "proxy", _KEPT),
    "scaled colour": Lifetime("scaled colour", "proxy", _KEPT),
    "wide places": Lifetime("wide places", "proxy", _KEPT),
    "coc": Lifetime("coc", "coc", _KEPT),
    "out": Lifetime("out", "fragments", _KEPT),
    "blurred": Lifetime("blurred", "blur", _KEPT),
    "frame": Lifetime("frame", "limits", _KEPT),
    "in plate's light": Lifetime("in plate's light", "limits", _KEPT),
    "colours kept": Lifetime("colours kept", "coc", "colours"),
    # Alpha as a picture of its own, which is layered before the colour.
    "alpha plate": Lifetime("alpha plate", "alpha", "highlights drawn"),
    "alpha out": Lifetime("alpha out", "fragments", "limits"),
    # Highlights: what a pixel is compared with, at half the size; the picture in two; their discs.
    "surroundings": Lifetime("hidden cost", "highlights found", "highlights found", 1),
    "surroundings coc": Lifetime("layer coc", "highlights found", "highlights found", 2),
    "surroundings blurred": Lifetime("layer", "highlights found", "highlights found", 2),
    "surroundings poles": Lifetime("poles", "highlights found", "highlights found"),
    "low": Lifetime("low", "highlights found", "highlights drawn"),
    "low fragments": Lifetime("low fragments", "highlights found", "highlights drawn"),
    "around": Lifetime("around", "highlights found", "highlights drawn"),
    "high": Lifetime("layer", "highlights found", "highlights listed", 1),
    "highlight tally": Lifetime("highlight tally", "highlights listed", "highlights listed"),
    "highlight offset": Lifetime("highlight offset", "highlights listed", "highlights listed"),
    "highlight plan": Lifetime("highlight plan", "highlights listed", "highlights drawn"),
    "highlight sprite": Lifetime("highlight sprite", "highlights listed", "highlights drawn"),
    # The picture taken apart at its silhouettes.
    "kind": Lifetime("kind", "fragments", "highlights drawn"),
    "far": Lifetime("far", "fragments", "highlights drawn"),
    "near": Lifetime("near", "fragments", "highlights drawn"),
    "rim list": Lifetime("pixel list", "fragments", "fragments"),
    # Where each layer is worked on.
    "tile content": Lifetime("tile content", "fragments", "highlights drawn"),
    "tile nearest": Lifetime("tile nearest", "fragments", "highlights drawn"),
    "tile distance": Lifetime("tile distance", "tiles", "tiles"),
    "tile hider": Lifetime("tile hider", "tiles", "tiles"),
    "tile mask": Lifetime("tile mask", "tiles", "composite"),
    "tile list": Lifetime("tile list", "tiles", "composite"),
    # A layer.
    "layer": Lifetime("layer", "layer split", "composite"),
    "layer state": Lifetime("layer state", "layer split", "coc fill"),
    "told": Lifetime("told", "layer split", "hidden fill"),
    "hidden list": Lifetime("pixel list", "layer split", "hidden fill"),
    "hidden bits": Lifetime("hidden bits", "hidden fill", "hidden fill"),
    "hidden blocks": Lifetime("hidden blocks", "hidden fill", "hidden fill"),
    "hidden cost": Lifetime("hidden cost", "hidden fill", "hidden fill"),
    "hidden match": Lifetime("hidden match", "hidden fill", "hidden fill"),
    "layer coc": Lifetime("layer coc", "coc fill", "blur"),
    "coc fill rows": Lifetime("coc fill rows", "coc fill", "coc fill"),
    "poles": Lifetime("poles", "blur", "blur"),
    # The other methods.
    "gather weight": Lifetime("cover", "gather", "gather"),
    "gather weights": Lifetime("layer", "gather", "gather", 1),
    "bin light": Lifetime("layer", "scatter", "scatter", 1),
    "bin cover": Lifetime("cover", "scatter", "scatter"),
    "scatter cover": Lifetime("scatter cover", "scatter", "scatter"),
    "scatter places": Lifetime("scatter places", "scatter", "scatter"),
    "scatter order": Lifetime("pixel list", "scatter", "scatter"),
    "pyramid": Lifetime("pyramid", "pyramid", "pyramid"),
}

_Held = moderngl.Texture | moderngl.TextureArray | moderngl.Buffer
Held = TypeVar("Held", moderngl.Texture, moderngl.TextureArray, moderngl.Buffer)


class Scratch:
    """The textures and buffers of one pipeline by their names in `LIFETIMES`."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._pool = TexturePool(ctx)
        self._alive: dict[str, tuple[str, _Held]] = {}  # the owner of each memory
        self._poisons = bool(os.environ.get(POISON_VARIABLE))

    def begin_picture(self) -> None:
        """End all lifetimes, because the last picture may not have been finished."""
        self._alive.clear()

    def texture(
        self,
        name: str,
        size: tuple[int, int],
        components: int,
        storage: Storage = "f4",
        reduction: int = 1,
    ) -> moderngl.Texture:
        """Return the texture called `name`, with its previous content.

        Each `reduction` has its own texture, so that textures are not created again for each
        layer. Raise RuntimeError if the memory still belongs to another name.
        """
        memory = _memory(name, reduction)
        return self._given(name, memory, self._pool.texture(memory, size, components, storage))

    def filled(
        self,
        name: str,
        size: tuple[int, int],
        value: tuple[float, float, float, float],
        reduction: int = 1,
    ) -> moderngl.Texture:
        """Return the RGBA float32 texture called `name`, filled with `value`."""
        memory = _memory(name, reduction)
        return self._given(name, memory, self._pool.filled(memory, size, value))

    def array(
        self,
        name: str,
        size: tuple[int, int],
        layers: int,
        components: int,
        storage: Storage = "f4",
    ) -> moderngl.TextureArray:
        """Return the texture array called `name`, with `layers` layers."""
        memory = _memory(name)
        made = self._pool.array(memory, size, layers, components, storage)
        return self._given(name, memory, made)

    def buffer(self, name: str, size_bytes: int) -> moderngl.Buffer:
        """Return the storage buffer called `name`, of at least `size_bytes`."""
        memory = _memory(name)
        return self._given(name, memory, self._pool.buffer(memory, size_bytes))

    def passed(self, name: str) -> str:
        """Free all memory that the pass `name` was the last to read; return the name."""
        for memory, (owner, held) in list(self._alive.items()):
            if LIFETIMES[owner].last == name:
                del self._alive[memory]
                if self._poisons:
                    _poison(held)
        return name

    def release(self) -> None:
        """Release all memory."""
        self._alive.clear()
        self._pool.release()

    def _given(self, name: str, memory: str, held: Held) -> Held:
        owner = self._alive.get(memory, (name, held))[0]
        if owner != name:
            raise RuntimeError(
                f"The memory '{memory}' still belongs to '{owner}', not to '{name}'."
            )
        self._alive[memory] = name, held
        return held


def _memory(name: str, reduction: int = 1) -> str:
    memory = LIFETIMES[name].memory
    return memory if reduction == 1 else f"{memory} / {reduction}"


def _poison(held: _Held) -> None:
    if isinstance(held, moderngl.Buffer):
        fill_buffer(held)
    else:
        fill_texture(held)
