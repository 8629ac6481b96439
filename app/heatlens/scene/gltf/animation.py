"""What moves in a glTF file. All its animations run at once, from frame 1 on.

Source: Khronos, glTF 2.0 specification, section 3.11 and appendix C.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heatlens.model.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.scene.gltf.accessor import read_floats
from heatlens.scene.gltf.file import GltfFile
from heatlens.scene.gltf.json_values import Record
from heatlens.scene.gltf.nodes import RESTS, NodeTree, matrices
from heatlens.scene.scene import Array

Indices = NDArray[np.intp]

FIRST_FRAME = 1
# Over an hour; a camera gets a key for each of them.
_FRAMES_MOST = 100_000
_A_HAIR = 1e-3  # of a frame, by which a time in float32 may miss a whole one
_TWICE = "Animations that move the same thing at once: the first of them is played."


@dataclass(frozen=True, eq=False)
class ValueTrack:
    """Values over time.

    times_s  (K,) in ascending order
    values   (K, n); (K, 3, n) for a cubic: tangent in, value, tangent out
    kind     LINEAR, STEP or CUBICSPLINE
    """

    times_s: Array
    values: Array
    kind: str = "LINEAR"
    is_rotation: bool = False

    def at(self, times_s: Array) -> Array:
        """Return (T, n) values at T times, constant before the first and after the last key."""
        if len(self.times_s) == 1:
            only = self.values[0, 1] if self.kind == "CUBICSPLINE" else self.values[0]
            return np.tile(only, (len(times_s), 1))
        inner = np.clip(times_s, self.times_s[0], self.times_s[-1])
        after = np.searchsorted(self.times_s, inner, side="right")
        before = np.clip(after - 1, 0, max(len(self.times_s) - 2, 0))
        after = np.minimum(before + 1, len(self.times_s) - 1)
        span = self.times_s[after] - self.times_s[before]
        share = np.where(span > 0, (inner - self.times_s[before]) / np.where(span > 0, span, 1), 1)
        return np.asarray(
            _BETWEEN[self.kind](self, before, after, span[:, None], share[:, None]), np.float64
        )


def _step(track: ValueTrack, before: Indices, after: Indices, span: Array, share: Array) -> Array:
    return np.where(share < 1, track.values[before], track.values[after])


def _linear(track: ValueTrack, before: Indices, after: Indices, span: Array, share: Array) -> Array:
    a, b = track.values[before], track.values[after]
    if not track.is_rotation:
        return np.asarray(a + (b - a) * share)
    return _slerp(a, b, share)


def _cubic(track: ValueTrack, before: Indices, after: Indices, span: Array, share: Array) -> Array:
    """Interpolate by the cubic spline of glTF 2.0, appendix C.5."""
    t = share
    a, leaving = track.values[before, 1], track.values[before, 2]
    arriving, b = track.values[after, 0], track.values[after, 1]
    return np.asarray(
        (2 * t**3 - 3 * t**2 + 1) * a
        + span * (t**3 - 2 * t**2 + t) * leaving
        + (3 * t**2 - 2 * t**3) * b
        + span * (t**3 - t**2) * arriving
    )


def _slerp(a: Array, b: Array, share: Array) -> Array:
    """Interpolate along the shorter arc, linearly where both ends are nearly equal.

    Shoemake 1985.
    """
    cosine = np.sum(a * b, axis=1, keepdims=True)
    b, cosine = np.where(cosine < 0, -b, b), np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    near = sine < 1e-6
    safe = np.where(near, 1.0, sine)
    first = np.where(near, 1 - share, np.sin((1 - share) * angle) / safe)
    last = np.where(near, share, np.sin(share * angle) / safe)
    return np.asarray(first * a + last * b)


_BETWEEN: Mapping[str, Callable[[ValueTrack, Indices, Indices, Array, Array], Array]] = {
    "STEP": _step,
    "LINEAR": _linear,
    "CUBICSPLINE": _cubic,
}


@dataclass(frozen=True, eq=False)
class Animation:
    """The tracks of each node that moves, one for each of RESTS, even if it has a single key."""

    tree: NodeTree
    tracks: dict[int, dict[str, ValueTrack]]
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once

    @property
    def frames(self) -> FrameRange | None:
        """From frame 1 to the last key; None where nothing moves."""
        ends = [float(t.times_s[-1]) for node in self.tracks.values() for t in node.values()]
        if not ends:
            return None
        count = math.ceil(max(ends) * FRAMES_PER_SECOND - _A_HAIR)
        return FrameRange(FIRST_FRAME, FIRST_FRAME + max(count, 0))

    def locals_of(self, node: int, frames: Array) -> Array:
        """Return (F, 4, 4) of one node within its parent over that many frames."""
        tracks = self.tracks.get(node)
        if tracks is None:
            return np.broadcast_to(self.tree.locals[node], (len(frames), 4, 4))
        times_s = (frames - FIRST_FRAME) / FRAMES_PER_SECOND
        return matrices(*(tracks[name].at(times_s) for name in RESTS))

    def worlds(self, frame: float) -> Array:
        """Return (N, 4, 4) of all nodes to the world."""
        if not self.tracks:
            return self.tree.worlds()
        at = np.array([(frame - FIRST_FRAME) / FRAMES_PER_SECOND])
        moved = self.tracks.values()
        values = (np.concatenate([tracks[name].at(at) for tracks in moved]) for name in RESTS)
        return self.tree.worlds(dict(zip(self.tracks, matrices(*values), strict=True)))

    def moves(self, node: int) -> bool:
        """Return whether a node or one of its ancestors moves."""
        return bool(self.tracks) and any(above in self.tracks for above in self.tree.chain(node))

    @np.errstate(over="ignore", invalid="ignore")  # the caller checks the result
    def track_of(self, node: int, frames: Array) -> Array:
        """Return (F, 4, 4) of one node to the world."""
        found = np.broadcast_to(np.eye(4), (len(frames), 4, 4))
        for above in self.tree.chain(node):
            found = self.locals_of(above, frames) @ found
        return found


def read_animation(gltf: GltfFile, tree: NodeTree) -> Animation:
    """Read the animations of a file.

    Raises InputError where they are damaged or longer than an hour.
    """
    found = Animation(tree, {})
    seen = set(tree.seen)
    for record in gltf.listed("animations"):
        samplers = record.records("samplers")
        for channel in record.records("channels"):
            _add(gltf, found, seen, samplers, channel)
    for node, tracks in found.tracks.items():
        for name, rest in RESTS.items():
            tracks.setdefault(name, _still(tree.records[node].row(name, rest)))
    frames = found.frames
    if frames is not None and frames.count > _FRAMES_MOST:
        gltf.root.refuse(
            f"its animation has {frames.count:,} frames; {_FRAMES_MOST:,} are the most"
        )
    return found


def _still(value: tuple[float, ...]) -> ValueTrack:
    return ValueTrack(np.zeros(1), np.array([value], float))


def _add(
    gltf: GltfFile, found: Animation, seen: set[int], samplers: list[Record], channel: Record
) -> None:
    """Add a channel if it moves a node of the scene."""
    target = channel.inside("target")
    node = target.index("node", len(gltf.listed("nodes")))
    path = target.text("path")
    if node not in seen or path not in RESTS:
        return
    if gltf.listed("nodes")[node].has("matrix"):
        target.refuse(f"node {node} has a matrix, which cannot be moved by its {path}")
    number = channel.index("sampler", len(samplers))
    if number is None:
        channel.refuse("the entry 'sampler' is missing")
    if path in found.tracks.get(node, {}):
        found.notes[_TWICE] = None
        return
    found.tracks.setdefault(node, {})[path] = _track(gltf, samplers[number], path)


def _track(gltf: GltfFile, sampler: Record, path: str) -> ValueTrack:
    kind = sampler.text("interpolation", "LINEAR")
    if kind not in _BETWEEN:
        sampler.refuse(f"{kind[:20]!r} is not an interpolation of glTF")
    accessors = gltf.listed("accessors")
    places = [sampler.index(name, len(accessors)) for name in ("input", "output")]
    if places[0] is None or places[1] is None:
        sampler.refuse("its times or its values are missing")
    times_s = read_floats(gltf, places[0], 1)[:, 0].astype(float)
    values = read_floats(gltf, places[1], len(RESTS[path])).astype(float)
    per_key = 3 if kind == "CUBICSPLINE" else 1
    if not len(times_s) or len(values) != per_key * len(times_s):
        sampler.refuse(f"{len(times_s)} times do not match {len(values)} values")
    if times_s[0] < 0 or (np.diff(times_s) < 0).any() or times_s[-1] > 1e6:
        sampler.refuse("its times should rise from 0 on, in seconds")
    if path == "rotation" and kind != "CUBICSPLINE":
        values /= np.maximum(np.linalg.norm(values, axis=1, keepdims=True), 1e-12)
    if kind == "CUBICSPLINE":
        values = values.reshape(len(times_s), 3, -1)
    return ValueTrack(times_s, values, kind, path == "rotation")
