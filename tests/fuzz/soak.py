"""Render many small frames one after the other, and check that memory and OpenGL objects stay.

    python tests/fuzz/soak.py --frames 10000                   # of the renderer and of the window
    python tests/fuzz/soak.py --frames 2000 --only window --seed 3

Plates of several sizes, methods, qualities, bokehs, layers, proxies and lenses come in a random
order, the same for the same seed. At each tenth of the frames the renderer lets go of its plate and
the window shows its first state; then the resident memory and the objects of OpenGL that are alive
are told, programs apart, which stay once they are built. From the first quarter on, when every
program has been built, the objects must stay equal, and the memory may grow by a few megabytes, as
allocators keep some.
"""

import argparse
import ctypes
import os
import random
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.context import headless_context
from support.gui import gui_of
from support.plates import plate_of, room
from support.session_files import QUICK, room_file

SIZES = ((32, 18), (48, 32), (33, 19), (64, 20))
GROWTH_MOST_BYTES = 24_000_000  # from the first quarter on
_NAMES_LEAST = 4096  # that are looked at; drivers that reuse names give the smallest free one
_KINDS = {
    "Texture": "Textures",
    "Buffer": "Buffers",
    "Framebuffer": "Framebuffers",
    "VertexArray": "VertexArrays",
    "Sampler": "Samplers",
    "Query": "Queries",
}
_METHODS = tuple(method for method in Method if not method.needs_scene)


@dataclass(frozen=True)
class ProcessState:
    """The memory and OpenGL objects of a process after a number of frames."""

    frames: int
    memory_bytes: int
    objects: dict[str, int]  # of OpenGL, by kind

    def __str__(self) -> str:
        object_counts = ", ".join(f"{count} {kind.lower()}" for kind, count in self.objects.items())
        return f"{self.frames:,} frames: {self.memory_bytes / 1e6:.1f} MB resident; {object_counts}"


def process_state(frames: int) -> ProcessState:
    """Count the objects of the present context, and the memory of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return ProcessState(frames, pages * os.sysconf("SC_PAGE_SIZE"), gl_objects())


def gl_objects() -> dict[str, int]:
    """Return the number of OpenGL objects of each kind, by testing each name with glIs…."""
    library = ctypes.CDLL("libGL.so.1")
    counts = {}
    for kind, kinds in _KINDS.items():
        is_one = getattr(library, f"glIs{kind}")
        is_one.restype = ctypes.c_ubyte
        names = range(1, max(_new_name(library, kinds), _NAMES_LEAST))
        counts[kinds] = sum(is_one(name) for name in names)
    return counts


def _new_name(library: ctypes.CDLL, kinds: str) -> int:
    """Return the name that the next object gets; some drivers never reuse names."""
    name = ctypes.c_uint()
    getattr(library, f"glGen{kinds}")(1, ctypes.byref(name))
    getattr(library, f"glDelete{kinds}")(1, ctypes.byref(name))
    return name.value


def growth_faults(points: list[ProcessState]) -> list[str]:
    """Return descriptions of what grew after the first quarter of the frames."""
    settled_states = [state for state in points if state.frames >= points[-1].frames / 4]
    first, fault_texts = settled_states[0], []
    for state in settled_states[1:]:
        if state.objects != first.objects:
            fault_texts.append(
                f"after {state.frames:,} frames there are {state.objects}, not {first.objects}"
            )
    growth = settled_states[-1].memory_bytes - first.memory_bytes
    if growth > GROWTH_MOST_BYTES:
        fault_texts.append(f"memory grew by {growth / 1e6:.1f} MB after {first.frames:,} frames")
    return fault_texts


def render_frames(frames: int, seed: int) -> Iterator[ProcessState]:
    """Render `frames` frames with one FrameRenderer; yield its state after each tenth."""
    rng, ctx = random.Random(seed), headless_context()
    renderer = FrameRenderer(ctx)
    plates = [plate_of(*room(*size)) for size in SIZES]
    for number in range(frames):
        if number % 8 == 0:
            renderer.load(rng.choice(plates))
        renderer.render(random_shot(rng, number % frames), 0)
        if (number + 1) % max(frames // 10, 1) == 0:
            assert ctx.error == ""
            renderer.unload()
            yield process_state(number + 1)
            renderer.load(plates[0])


def random_shot(rng: random.Random, number: int) -> Shot:
    """Return a lens and a blur; the first hundred try every method, bokeh and quality in turn."""
    method, bokeh = _METHODS[number % len(_METHODS)], list(Bokeh)[number // 5 % len(Bokeh)]
    quality = list(Quality)[number // 15 % len(Quality)]
    lens = Lens(rng.uniform(20, 135), rng.uniform(1.2, 16), rng.uniform(0.6, 12), 36.0)
    layers, proxy = rng.choice((None, 1, 3, 7)), rng.choice((1.0, 0.5, 0.25))
    return Shot(lens, DefocusSettings(bokeh, quality, layers, proxy, method))


def draw_window_frames(frames: int, seed: int) -> Iterator[ProcessState]:
    """Draw `frames` frames of the window without a display while settings change; yield states."""
    rng, ctx = random.Random(seed), headless_context()
    with tempfile.TemporaryDirectory(prefix="heatlens-soak-") as folder:
        os.environ |= {f"HEATLENS_{name}_DIR": folder for name in ("CONFIG", "CACHE", "LOG")}
        plate = room_file(Path(folder) / "room.exr")
        with gui_of(ctx, plate, size=(640, 400), defocus=QUICK) as gui:
            editing = gui.session.editing
            first = editing.shot
            for number in range(frames):
                if number % 3 == 0:
                    editing.edit(replace(random_shot(rng, number), source=first.source))
                gui.frame()
                gui.session.work()
                if (number + 1) % max(frames // 10, 1) == 0:
                    editing.edit(first)
                    gui.settled()
                    yield process_state(number + 1)


KINDS = {"renderer": render_frames, "window": draw_window_frames}


def main() -> int:
    """Soak what the command line names; return 1 if memory grew."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--frames", type=int, default=1000, help="of each")
    parser.add_argument("--only", default=",".join(KINDS))
    parser.add_argument("--seed", type=int, default=20060106)
    args = parser.parse_args()
    is_bad = False
    for name in args.only.split(","):
        states: list[ProcessState] = []
        for state in KINDS[name](args.frames, args.seed):
            states.append(state)
            print(f"{name}: {state}", flush=True)
        fault_texts = growth_faults(states)
        print(f"{name}: " + ("; ".join(fault_texts) or "nothing grew"), flush=True)
        is_bad |= bool(fault_texts)
    return int(is_bad)


if __name__ == "__main__":
    sys.exit(main())
