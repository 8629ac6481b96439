"""A texture of display values that knows what it shows."""

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture

Key = tuple[object, ...]


class ScreenTarget:
    """An 8-bit texture with a key that identifies its content."""

    def __init__(self, ctx: Device, label: str) -> None:
        self._ctx = ctx
        self._label = label
        self._key: Key | None = None  # identifies the content; None if nothing is drawn yet
        self.texture: Texture | None = None

    def needs_update(self, size: tuple[int, int], key: Key) -> bool:
        """Resize to `size`; return True if the content is not that of `key` and must be drawn.

        `key` counts as the content from now on.
        """
        self.resized(size)
        is_changed, self._key = self._key != key, key
        return is_changed

    def resized(self, size: tuple[int, int]) -> Texture:
        """Return the texture, a new and empty one if it had another size."""
        if self.texture is None or self.texture.size != size:
            if self.texture is not None:
                self.texture.release()
            self.texture = self._ctx.texture(size, 4)
            self.texture.repeats = False
            self.texture.label = self._label
            self._key = None
        return self.texture
