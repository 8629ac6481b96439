"""Read the animations of a glTF file: all of them at once, or the chosen one.

Source: Khronos, glTF 2.0 specification, section 3.11 and appendix C.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.gltf.nodes import (
    ANGLE,
    DEFAULT_TRANSFORM,
    WEIGHTS,
    NodeTree,
    compose_matrices,
    read_target,
)
from heatlens.media.scene.gltf.value_track import INTERPOLATIONS, ValueTrack
from heatlens.media.scene.gltf.vertices import read_floats
from heatlens.media.scene.scene import Array

_FIRST_FRAME = 1
# More than an hour; a camera gets a key for each frame.
_FRAMES_MOST = 100_000
_ROUNDING_FRAMES = 1e-3  # tolerance in frames for times that are rounded to float32
_MOVED_TWICE_NOTE = (
    "Several animations move the same node; the first is played, or the one that --clip names"
)


@dataclass(frozen=True, eq=False)
class Animation:
    """The animated values of a file.

    tracks   by node that moves, a track for each property of a transform
    weights  by node, the weights of its morph targets
    angles   by camera of the file, its vertical angle of view in radians
    clips    the names of all animations of the file
    """

    tree: NodeTree
    timing: SceneTiming
    tracks: dict[int, dict[str, ValueTrack]] = field(default_factory=dict)
    weights: dict[int, ValueTrack] = field(default_factory=dict)
    angles: dict[int, ValueTrack] = field(default_factory=dict)
    clips: tuple[str, ...] = ()
    _latest_worlds: list[tuple[float, Array]] = field(default_factory=list)  # frame and worlds

    @cached_property
    def _span_s(self) -> tuple[float, float] | None:
        """The times of the first and the last key, None if nothing moves."""
        animated = [t for node in self.tracks.values() for t in node.values() if t.is_animated]
        animated += [*self.weights.values(), *self.angles.values()]
        if not animated:
            return None
        ends = [(float(t.times_s[0]), float(t.times_s[-1])) for t in animated]
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
        count = math.ceil(length_s * self.timing.frames_per_second - _ROUNDING_FRAMES)
        return FrameRange(self.first_frame, self.first_frame + max(count, 0))

    def times_s(self, frames: Array) -> Array:
        """Return the times of frames in seconds."""
        return (frames - self.first_frame) / self.timing.frames_per_second + self._start_s

    def weights_of(self, node: int, frame: float) -> Array:
        """Return the animated weights of a node's morph targets at a frame."""
        return np.asarray(self.weights[node].sample(self.times_s(np.array([frame])))[0])

    def local_matrices_of(self, node: int, frames: Array) -> Array:
        """Return the matrices (F, 4, 4) from a node to its parent at F frames."""
        tracks = self.tracks.get(node)
        if tracks is None:
            return np.broadcast_to(self.tree.locals[node], (len(frames), 4, 4))
        times_s = self.times_s(frames)
        return compose_matrices(*(tracks[name].sample(times_s) for name in DEFAULT_TRANSFORM))

    def worlds(self, frame: float) -> Array:
        """Return the matrices (N, 4, 4) from all nodes to the world at a frame.

        The latest result is cached, because several skins ask for the same frame.
        """
        at_frame = frame if self.tracks else 0.0
        for cached_frame, worlds in self._latest_worlds:
            if cached_frame == at_frame:
                return worlds
        new_worlds = self.tree.worlds(self._local_matrices_at(frame))
        self._latest_worlds[:] = [(at_frame, new_worlds)]
        return new_worlds

    def _local_matrices_at(self, frame: float) -> dict[int, Array]:
        """Return the matrices (4, 4) from each moving node to its parent at a frame."""
        if not self.tracks:
            return {}
        times_s, moving_tracks = self.times_s(np.array([frame])), self.tracks.values()
        values = (
            np.concatenate([tracks[name].sample(times_s) for tracks in moving_tracks])
            for name in DEFAULT_TRANSFORM
        )
        return dict(zip(self.tracks, compose_matrices(*values), strict=True))

    def is_moving(self, node: int) -> bool:
        """Return whether a node or one of its ancestors moves."""
        return bool(self.tracks) and any(
            ancestor in self.tracks for ancestor in self.tree.chain(node)
        )

    @np.errstate(over="ignore", invalid="ignore")  # the caller checks the result
    def world_matrices_of(self, node: int, frames: Array) -> Array:
        """Return the matrices (F, 4, 4) from one node to the world at F frames."""
        to_world = np.broadcast_to(np.eye(4), (len(frames), 4, 4))
        for ancestor in self.tree.chain(node):
            to_world = self.local_matrices_of(ancestor, frames) @ to_world
        return to_world


def read_animation(gltf: GltfFile, tree: NodeTree, timing: SceneTiming) -> Animation:
    """Read the animations of a file, or the one that `timing` chooses.

    Raises InputError if they are damaged or longer than an hour, or there is no such clip.
    """
    records = gltf.top_level("animations")
    names = tuple(record.text("name") or f"clip {i + 1}" for i, record in enumerate(records))
    animation = Animation(tree, timing, clips=names)
    scene_nodes = set(tree.scene_nodes)
    for record in [records[i] for i in _select_animations(gltf, names, timing.clip)]:
        samplers = record.records("samplers")
        for channel in record.records("channels"):
            _add_channel(gltf, animation, scene_nodes, samplers, channel)
    for node, tracks in animation.tracks.items():
        for name, default in DEFAULT_TRANSFORM.items():
            tracks.setdefault(name, _make_constant_track(tree.records[node].row(name, default)))
    frames = animation.frames
    if frames is not None and frames.count > _FRAMES_MOST:
        gltf.root.refuse(
            f"its animation has {frames.count:,} frames; {_FRAMES_MOST:,} are the most"
        )
    return animation


def _select_animations(gltf: GltfFile, names: tuple[str, ...], clip: str | None) -> list[int]:
    """Return the numbers of the animations that are played. Raises InputError."""
    if clip is None:
        return list(range(len(names)))
    if clip in names:
        return [names.index(clip)]
    if clip.isdecimal() and 1 <= int(clip) <= len(names):
        return [int(clip) - 1]
    clip_names = ", ".join(names[:20]) or "none"
    raise InputError(f"{gltf.path} has no clip {clip!r}; its clips are: {clip_names}.")


def _make_constant_track(value: tuple[float, ...]) -> ValueTrack:
    """Return a track with a single key at 0 s."""
    return ValueTrack(np.zeros(1), np.array([value], float), is_animated=False)


def _add_channel(
    gltf: GltfFile,
    animation: Animation,
    scene_nodes: set[int],
    samplers: list[Record],
    channel: Record,
) -> None:
    """Add a channel if it moves a node of the scene, or changes its shape or a camera's angle."""
    target = read_target(gltf, channel)
    if target is None or (target.path != ANGLE and target.number not in scene_nodes):
        return
    sampler = samplers[channel.required_index("sampler", len(samplers))]
    path = target.path
    tracks_by_target = {WEIGHTS: animation.weights, ANGLE: animation.angles}.get(target.path)
    is_already_animated = (
        path in animation.tracks.get(target.number, ())
        if tracks_by_target is None
        else target.number in tracks_by_target
    )
    if is_already_animated:
        gltf.note_loss(_MOVED_TWICE_NOTE, channel)
        return
    track = _read_track(gltf, sampler, path)
    if tracks_by_target is None:
        animation.tracks.setdefault(target.number, {})[path] = track
    else:
        tracks_by_target[target.number] = track


def _check_times(sampler: Record, times_s: Array, values: Array, per_key: int) -> None:
    """Raise InputError unless the times rise from 0 on, with `per_key` values each."""
    if not len(times_s) or len(values) != per_key * len(times_s):
        sampler.refuse(f"{len(times_s)} times do not match {len(values)} values")
    if times_s[0] < 0 or (np.diff(times_s) < 0).any() or times_s[-1] > 1e6:
        sampler.refuse("its times should rise from 0 on, in seconds")


def _read_track(gltf: GltfFile, sampler: Record, path: str) -> ValueTrack:
    """Read the keys of a sampler, which animates the property `path` of its target."""
    kind = sampler.text("interpolation", "LINEAR")
    if kind not in INTERPOLATIONS:
        sampler.refuse(f"{kind[:20]!r} is not an interpolation of glTF")
    times, output = (
        gltf.required_index(sampler, name, "accessors") for name in ("input", "output")
    )
    times_s = read_floats(gltf, times, 1)[:, 0].astype(float)
    values = read_floats(gltf, output, len(DEFAULT_TRANSFORM.get(path, (0,)))).astype(float)
    per_key = 3 if kind == "CUBICSPLINE" else 1
    if path == WEIGHTS:
        values = _group_by_key(sampler, values, per_key * len(times_s))
    _check_times(sampler, times_s, values, per_key)
    if path == "rotation" and kind != "CUBICSPLINE":
        values /= np.maximum(np.linalg.norm(values, axis=1, keepdims=True), 1e-12)
    if kind == "CUBICSPLINE":
        values = values.reshape(len(times_s), 3, -1)
    return ValueTrack(times_s, values, kind, path == "rotation")


def _group_by_key(sampler: Record, values: Array, keys: int) -> Array:
    """Return weights (keys, shapes) from a flat list in which those of a key follow each other."""
    if not keys or len(values) % keys:
        sampler.refuse(f"{len(values)} weights cannot belong to {keys} keys")
    return values.reshape(keys, -1)
