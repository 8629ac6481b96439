"""Edit keys over frames, whatever they hold: a value of a lens, or the pose of a camera."""

from collections.abc import Collection, Iterable
from dataclasses import Field, replace
from typing import Any, ClassVar, Protocol, TypeVar

# Keys closer together than this count as one: no shutter is as fast, and no pointer as exact.
SAME_FRAME = 1e-3


class FrameKey(Protocol):
    """A dataclass that belongs to a frame."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def frame(self) -> float:
        """The frame; it may lie between two frames."""


K = TypeVar("K", bound=FrameKey)


def frame_of(key: FrameKey) -> float:
    """Return the frame of a key, to sort and search keys by."""
    return key.frame


def is_same_frame(frame: float, other_frame: float) -> bool:
    """Return True for two frames that hold one key."""
    return abs(frame - other_frame) < SAME_FRAME


def merge_keys(existing_keys: Iterable[K], added_keys: Collection[K]) -> tuple[K, ...]:
    """Return all keys in order; an added key replaces one at its frame."""
    unchanged_keys = [
        key
        for key in existing_keys
        if not any(is_same_frame(key.frame, added.frame) for added in added_keys)
    ]
    return tuple(sorted([*unchanged_keys, *added_keys], key=frame_of))


def move_keys(keys: Iterable[K], frames: Collection[float], by_frames: float) -> tuple[K, ...]:
    """Return the keys with those at `frames` moved; they replace those on which they land."""
    keys = tuple(keys)
    other_keys = [key for key in keys if key.frame not in frames]
    return paste_keys(other_keys, (key for key in keys if key.frame in frames), by_frames)


def ripple_keys(keys: Iterable[K], from_frame: float, by_frames: float) -> tuple[K, ...]:
    """Return the keys with all from `from_frame` on moved later or earlier.

    Moving earlier cuts frames out, and the keys in those frames are removed.
    """
    keys = tuple(keys)
    stay_until = from_frame + min(by_frames, 0.0)
    early_keys = [key for key in keys if key.frame < stay_until]
    return paste_keys(early_keys, (key for key in keys if key.frame >= from_frame), by_frames)


def paste_keys(existing_keys: Iterable[K], keys: Iterable[K], by_frames: float) -> tuple[K, ...]:
    """Return existing keys with copies of `keys` that are `by_frames` later."""
    moved_keys = [replace(key, frame=key.frame + by_frames) for key in keys]
    return merge_keys(existing_keys, moved_keys)
