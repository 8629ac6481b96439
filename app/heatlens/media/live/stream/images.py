"""Images that clients of the tev protocol build: planes of named channels, with size limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.live.stream.protocol import (
    CloseImage,
    CreateImage,
    Message,
    TevPacketError,
    UpdateImage,
)
from heatlens.media.plate.plate import FloatImage

MAX_IMAGES = 16
MAX_VALUES = 1 << 28  # float32 in all images together: 1 GiB, or 8K with eight channels

# This NaN, which no arithmetic produces, marks a pixel for which no client has sent a value.
_NOT_SENT = 0x7FC0_7E7F


@dataclass(frozen=True, eq=False)
class TevImage:
    """An image in the order of its channels; `planes[channel]` is (H, W) float32 from the top."""

    name: str
    width: int
    height: int
    planes: dict[str, FloatImage]


class TevImages:
    """The images that messages have created; if there are too many, the oldest is dropped."""

    def __init__(self, max_images: int = MAX_IMAGES, max_values: int = MAX_VALUES) -> None:
        self._max_images, self._max_values = max_images, max_values
        self._images: dict[str, TevImage] = {}  # the oldest first

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the images, the newest first."""
        return tuple(reversed(self._images))

    @property
    def value_count(self) -> int:
        """Number of float32 values in memory."""
        return sum(it.width * it.height * len(it.planes) for it in self._images.values())

    def get(self, name: str) -> TevImage | None:
        """Return the image called `name`, or None; the next message may change its planes."""
        return self._images.get(name)

    def apply(self, message: Message) -> bool:
        """Apply `message`, and return whether an image has changed.

        Raises TevPacketError, and leaves all images unchanged, if the message cannot be applied.
        """
        if isinstance(message, CreateImage):
            return self._create(message)
        if isinstance(message, UpdateImage):
            return self._update(message)
        if isinstance(message, CloseImage):
            return self._images.pop(message.name, None) is not None
        return False

    def _create(self, message: CreateImage) -> bool:
        """Create an image without pixels; drop the oldest images until it fits in the limits.

        Return True, because an image has changed. Raises TevPacketError.
        """
        count = message.width * message.height * len(message.channels)
        if count > self._max_values:
            raise TevPacketError(
                f"{message.name[:40]!r} has {count} values in all its channels; at most "
                f"{self._max_values} are accepted"
            )
        self._images.pop(message.name, None)
        while len(self._images) >= self._max_images or self.value_count + count > self._max_values:
            del self._images[next(iter(self._images))]
        shape = (message.height, message.width)
        planes = {channel: _unsent_plane(shape) for channel in message.channels}
        self._images[message.name] = TevImage(message.name, message.width, message.height, planes)
        return True

    def _update(self, message: UpdateImage) -> bool:
        """Copy the tiles of a message into its image. Return True, because it has changed."""
        image = self._images.get(message.name)
        if image is None:
            raise TevPacketError(f"no image {message.name[:40]!r} exists to update")
        for channel, tile in message.tiles.items():
            _check_tile(image, channel, tile, message)
        for channel, tile in message.tiles.items():
            rows = slice(message.y, message.y + tile.shape[0])
            image.planes[channel][rows, message.x : message.x + tile.shape[1]] = tile
        return True


def unsent_mask(plane: FloatImage) -> NDArray[np.bool_]:
    """Return a mask of the pixels of `plane` for which no client has sent a value yet."""
    mask: NDArray[np.bool_] = plane.view(np.uint32) == _NOT_SENT
    return mask


def _unsent_plane(shape: tuple[int, int]) -> FloatImage:
    """Return a plane (H, W) whose pixels are all marked as not sent."""
    return np.full(shape, _NOT_SENT, np.uint32).view(np.float32)


def _check_tile(image: TevImage, channel: str, tile: FloatImage, message: UpdateImage) -> None:
    """Raise TevPacketError for a tile outside the image, or of an unknown channel."""
    if channel not in image.planes:
        raise TevPacketError(f"{image.name[:40]!r} has no channel {channel[:40]!r}")
    height, width = tile.shape
    is_inside = 0 <= message.x <= image.width - width and 0 <= message.y <= image.height - height
    if not is_inside:
        raise TevPacketError(
            f"{width} x {height} pixels at {message.x}, {message.y} do not lie in "
            f"{image.name[:40]!r} of {image.width} x {image.height}"
        )
