"""Cameras with known axes, and strategies of shots with random keys, for tests of camera files."""

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Interpolation, Scale
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.media.camera.samples import CameraSamples, fields_of

FRAMES = FrameRange(1001, 1008)
EYE = (0.2, 1.3, -0.4)
TARGET = (0.7, 0.9, 2.1)


def axes(eye: Sequence[float], target: Sequence[float], up: Sequence[float] = (0, 1, 0)):
    """Return right, up and forward of a camera in a right-handed world, each of length 1."""
    forward = np.subtract(target, eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right = right / np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def world_to_camera(eye: Sequence[float], target: Sequence[float]) -> tuple:
    """Return the world-to-camera matrix as in CameraSamples: column vectors, looking along -z."""
    right, up, forward = axes(eye, target)
    rows = [[*axis, -np.dot(axis, eye)] for axis in (right, up, -forward)]
    return tuple(tuple(map(float, row)) for row in [*rows, [0, 0, 0, 1]])


def exr_attribute(eye: Sequence[float], target: Sequence[float]) -> np.ndarray:
    """Return the EXR attribute `worldToCamera` of the camera: row vectors, looking along +z."""
    right, up, forward = axes(eye, target)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, up, forward], axis=1)
    matrix[3, :3] = [-np.dot(axis, eye) for axis in (right, up, forward)]
    return matrix.astype(np.float32)


def dolly(frames: FrameRange = FRAMES) -> list[tuple[float, ...]]:
    """Return the positions of a camera that moves at each frame."""
    return [tuple(np.add(EYE, (0.05 * n, 0.01 * n, -0.02 * n * n))) for n in range(frames.count)]


def moving_camera(**changes: object) -> CameraSamples:
    """Return a camera with a focus pull to infinity, zoom and dolly; f-stop, sensor are fixed."""
    count = FRAMES.count
    values = {
        "name": "hero cam",
        "frames": tuple(FRAMES),
        "focal_length_mm": tuple(50.0 + n / 3 for n in range(count)),
        "f_stop": (1.3,) * count,
        "focus_distance_m": (*(0.94 * 1.7**n for n in range(count - 1)), np.inf),
        "sensor_width_mm": (36.0,) * count,
        "sensor_height_mm": (20.25,) * count,
        "squeeze": (1.8,) * count,
        "world_to_camera": tuple(world_to_camera(eye, TARGET) for eye in dolly()),
        "frames_per_second": 25.0,
    }
    return CameraSamples(**fields_of(values | changes))


def _curve(values: st.SearchStrategy[float], scale: Scale) -> st.SearchStrategy[Curve]:
    key = st.tuples(values, st.sampled_from(list(Interpolation)))
    keyed = st.dictionaries(st.integers(FRAMES.first - 3, FRAMES.last + 3), key, max_size=4)
    return keyed.map(
        lambda keys_by_frame: Curve(
            tuple(Key(frame, *keys_by_frame[frame]) for frame in sorted(keys_by_frame)), scale
        )
    )


CURVES = st.builds(
    LensCurves,
    focus_distance_m=st.one_of(
        _curve(st.floats(0.4, 1e4) | st.just(np.inf), Scale.RECIPROCAL),
        _curve(st.floats(0.4, 1e4), Scale.LINEAR),
    ),
    f_stop=_curve(st.floats(0.7, 32), Scale.LOGARITHMIC),
    focal_length_mm=_curve(st.floats(8, 300), Scale.LOGARITHMIC),
    squeeze=_curve(st.floats(1.01, 1.99), Scale.LINEAR),
)
SHOTS = st.builds(
    Shot,
    lens=st.builds(
        Lens,
        focal_length_mm=st.floats(8, 300),
        f_stop=st.floats(0.7, 32),
        focus_distance_m=st.floats(0.4, 1e4) | st.just(np.inf),
        sensor_width_mm=st.floats(5, 70),
        squeeze=st.floats(1, 2),
    ),
    curves=CURVES,
    frames=st.just(FRAMES),
    frames_per_second=st.sampled_from([23.976, 24.0, 25.0, 60.0]),
)
