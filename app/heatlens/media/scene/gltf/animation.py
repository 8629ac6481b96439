"""Read the animations of a glTF file: all of them at once, or the chosen one.

Source: Khronos, glTF 2.0 specification, section 3.11 and appendix C.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.nodes import ANGLE, RESTS, WEIGHTS, NodeTree, matrices, target_of
from heatlens.media.scene.gltf.vertices import read_floats
from heatlens.media.scene.scene import Array

Indices = NDArray[np.intp]

_FIRST_FRAME = 1
# More than an hour; a camera gets a key for each frame.
_FRAMES_MOST = 100_000
_A_HAIR = 1e-3  # tolerance in frames for times that are rounded to float32
_TWICE = "Several animations move the same node; the first is played, or the one that --clip names"


@dataclass(frozen=True, eq=False)
class ValueTrack:
    """Values over time.

    times_s  (K,) in ascending order
    values   (K, n); (K, 3, n) for a cubic: tangent in, value, tangent out
    kind     LINEAR, STEP or CUBICSPLINE
    is_animated  True if an animation has it; False for the default track of a node at rest
    """

    times_s: Array
    values: Array
    kind: str = "LINEAR"
    is_rotation: bool = False
    is_animated: bool = True

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
    """The animated values of a file.

    tracks   by moving node, one for each of RESTS, even if it has a single key
    weights  by node, the weights of its morph targets
    angles   by camera of the file, its vertical angle of view
    clips    the names of all animations of the file
    """

    tree: NodeTree
    timing: SceneTiming
    tracks: dict[int, dict[str, ValueTrack]] = field(default_factory=dict)
    weights: dict[int, ValueTrack] = field(default_factory=dict)
    angles: dict[int, ValueTrack] = field(default_factory=dict)
    clips: tuple[str, ...] = ()
    _latest: list[tuple[float, Array]] = field(default_factory=list)  # frame and worlds

    @cached_property
    def _span_s(self) -> tuple[float, float] | None:
        """Return the times of the first and the last key, None if nothing moves."""
        moving = [t for node in self.tracks.values() for t in node.values() if t.is_animated]
        moving += [*self.weights.values(), *self.angles.values()]
        if not moving:
            return None
        ends = [(float(t.times_s[0]), float(t.times_s[-1])) for t in moving]
        return min(start for start, _ in ends), max(end for _, end in ends)

    @property
    def first_frame(self) -> int:
        """The first frame, even if nothing moves."""
        return _FIRST_FRAME if self.timing.first_frame is None else self.timing.first_frame

    @property
    def _start_s(self) -> float:
        """The time of the first frame in seconds."""
        has_start = self.timing.first_frame is not None and self._span_s is not None
        return self._span_s[0] if has_start and self._span_s is not None else 0.0

    @property
    def frames(self) -> FrameRange | None:
        """The range from the first frame to the last key; None if nothing moves."""
        if self._span_s is None:
            return None
        length_s = self._span_s[1] - self._start_s
        count = math.ceil(length_s * self.timing.frames_per_second - _A_HAIR)
        return FrameRange(self.first_frame, self.first_frame + max(count, 0))

    def times_s(self, frames: Array) -> Array:
        """Return the times of frames in seconds."""
        return (frames - self.first_frame) / self.timing.frames_per_second + self._start_s

    def weights_of(self, node: int, frame: float) -> Array:
        """Return the animated weights of a node's morph targets at a frame."""
        return np.asarray(self.weights[node].at(self.times_s(np.array([frame])))[0])

    def locals_of(self, node: int, frames: Array) -> Array:
        """Return the matrices (F, 4, 4) from a node to its parent at F frames."""
        tracks = self.tracks.get(node)
        if tracks is None:
            return np.broadcast_to(self.tree.locals[node], (len(frames), 4, 4))
        times_s = self.times_s(frames)
        return matrices(*(tracks[name].at(times_s) for name in RESTS))

    def worlds(self, frame: float) -> Array:
        """Return the matrices (N, 4, 4) from all nodes to the world at a frame."""
        at_frame = frame if self.tracks else 0.0
        for held, worlds in self._latest:
            if held == at_frame:
                return worlds
        placed = self.tree.worlds(self._locals_at(frame))
        self._latest[:] = [(at_frame, placed)]  # several skins ask for the same frame
        return placed

    def _locals_at(self, frame: float) -> dict[int, Array]:
        if not self.tracks:
            return {}
        at, moved = self.times_s(np.array([frame])), self.tracks.values()
        values = (np.concatenate([tracks[name].at(at) for tracks in moved]) for name in RESTS)
        return dict(zip(self.tracks, matrices(*values), strict=True))

    def moves(self, node: int) -> bool:
        """Return whether a node or one of its ancestors moves."""
        return bool(self.tracks) and any(above in self.tracks for above in self.tree.chain(node))

    @np.errstate(over="ignore", invalid="ignore")  # the caller checks the result
    def track_of(self, node: int, frames: Array) -> Array:
        """Return the matrices (F, 4, 4) from one node to the world at F frames."""
        to_world = np.broadcast_to(np.eye(4), (len(frames), 4, 4))
        for above in self.tree.chain(node):
            to_world = self.locals_of(above, frames) @ to_world
        return to_world


def read_animation(gltf: GltfFile, tree: NodeTree, timing: SceneTiming) -> Animation:
    """Read the animations of a file, or the one that `timing` chooses.

    Raises InputError if they are damaged or longer than an hour, or there is no such clip.
    """
    records = gltf.listed("animations")
    names = tuple(record.text("name") or f"clip {i + 1}" for i, record in enumerate(records))
    animation = Animation(tree, timing, clips=names)
    seen = set(tree.seen)
    for record in [records[i] for i in _chosen(gltf, names, timing.clip)]:
        samplers = record.records("samplers")
        for channel in record.records("channels"):
            _add(gltf, animation, seen, samplers, channel)
    for node, tracks in animation.tracks.items():
        for name, rest in RESTS.items():
            tracks.setdefault(name, _still(tree.records[node].row(name, rest)))
    frames = animation.frames
    if frames is not None and frames.count > _FRAMES_MOST:
        gltf.root.refuse(
            f"its animation has {frames.count:,} frames; {_FRAMES_MOST:,} are the most"
        )
    return animation


def _chosen(gltf: GltfFile, names: tuple[str, ...], clip: str | None) -> list[int]:
    """Return the numbers of the animations that are played."""
    if clip is None:
        return list(range(len(names)))
    if clip in names:
        return [names.index(clip)]
    if clip.isdecimal() and 1 <= int(clip) <= len(names):
        return [int(clip) - 1]
    known = ", ".join(names[:20]) or "none"
    raise InputError(f"{gltf.path} has no clip {clip!r}; its clips are: {known}.")


def _still(value: tuple[float, ...]) -> ValueTrack:
    return ValueTrack(np.zeros(1), np.array([value], float), is_animated=False)


def _add(
    gltf: GltfFile, made: Animation, seen: set[int], samplers: list[Record], channel: Record
) -> None:
    """Add a channel if it moves a node of the scene, or changes its shape or a camera's angle."""
    target = target_of(gltf, channel)
    if target is None or (target.path != ANGLE and target.number not in seen):
        return
    sampler = samplers[channel.needed("sampler", len(samplers))]
    path, of_file = target.path, {WEIGHTS: made.weights, ANGLE: made.angles}.get(target.path)
    is_taken = (
        path in made.tracks.get(target.number, ()) if of_file is None else target.number in of_file
    )
    if is_taken:
        gltf.lose(_TWICE, channel)
        return
    track = _track(gltf, sampler, path)
    if of_file is None:
        made.tracks.setdefault(target.number, {})[path] = track
    else:
        of_file[target.number] = track


def _check_times(sampler: Record, times_s: Array, values: Array, per_key: int) -> None:
    if not len(times_s) or len(values) != per_key * len(times_s):
        sampler.refuse(f"{len(times_s)} times do not match {len(values)} values")
    if times_s[0] < 0 or (np.diff(times_s) < 0).any() or times_s[-1] > 1e6:
        sampler.refuse("its times should rise from 0 on, in seconds")


def _track(gltf: GltfFile, sampler: Record, path: str) -> ValueTrack:
    kind = sampler.text("interpolation", "LINEAR")
    if kind not in _BETWEEN:
        sampler.refuse(f"{kind[:20]!r} is not an interpolation of glTF")
    times, output = (gltf.needed(sampler, name, "accessors") for name in ("input", "output"))
    times_s = read_floats(gltf, times, 1)[:, 0].astype(float)
    values = read_floats(gltf, output, len(RESTS.get(path, (0,)))).astype(float)
    per_key = 3 if kind == "CUBICSPLINE" else 1
    if path == WEIGHTS:
        values = _by_key(sampler, values, per_key * len(times_s))
    _check_times(sampler, times_s, values, per_key)
    if path == "rotation" and kind != "CUBICSPLINE":
        values /= np.maximum(np.linalg.norm(values, axis=1, keepdims=True), 1e-12)
    if kind == "CUBICSPLINE":
        values = values.reshape(len(times_s), 3, -1)
    return ValueTrack(times_s, values, kind, path == "rotation")


def _by_key(sampler: Record, values: Array, keys: int) -> Array:
    """Return (keys, shapes) of weights that follow each other."""
    if not keys or len(values) % keys:
        sampler.refuse(f"{len(values)} weights cannot belong to {keys} keys")
    return values.reshape(keys, -1)
