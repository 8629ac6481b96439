"""Compose what the window shows of a picture, and take it from the GPU.

That happens whenever the picture is new and a page can take it.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.render.display.picture_pass import Detail, PicturePass, PlacedPicture
from heatlens.render.gpu.device import Device, Framebuffer, Sampling, Texture
from heatlens.studio.board.board import Board
from heatlens.studio.session.session import Session
from heatlens.studio.share.page_state import PageState
from heatlens.studio.share.picture import Picture, Pixels, in_display
from heatlens.studio.share.shared import SharedSession

# On a processor without a GPU, drawing and reading previews took over half of the loop at 720p,
# most of it for pixels that a preview does not have. The picture at rest keeps its size.
_PREVIEW_PX = 720  # width of a preview at most: drawing it must not hold up the next one


@dataclass(frozen=True, eq=False)
class Seen:
    """A picture in display values, what lies over it, and the windows that it fills."""

    texture: Texture
    data: Box
    display: Box
    detail: Detail | None = None
    overlay: Texture | None = None

    @property
    def is_bare(self) -> bool:
        """True for a picture of full size with nothing over it."""
        is_full = self.texture.size == (self.data.width, self.data.height)
        return is_full and self.detail is None and self.overlay is None


class Composed:
    """Draws pictures for pages."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._pass = PicturePass(ctx)
        self._target: Framebuffer | None = None

    def pixels(self, seen: Seen) -> Pixels:
        """Return the pixels of the display window, (H, W, 4), the top row first."""
        if seen.is_bare:
            pixels = np.empty((seen.texture.height, seen.texture.width, 4), np.uint8)
            seen.texture.read_into(pixels.data.cast("B"))
            return in_display(pixels, seen.data, seen.display)
        scale = 1.0 if seen.detail is None else min(1.0, _PREVIEW_PX / seen.display.width)
        size = max(1, round(seen.display.width * scale)), max(1, round(seen.display.height * scale))
        target = self._sized(size)
        target.use()
        target.clear(0.0, 0.0, 0.0, 1.0)
        self._pass.run(_placed(seen, scale, size), target, size)
        pixels = np.empty((size[1], size[0], 4), np.uint8)
        target.read_into(pixels.data.cast("B"), components=4)
        return pixels[::-1]

    def _sized(self, size: tuple[int, int]) -> Framebuffer:
        if self._target is None or self._target.size != size:
            self.release()
            self._target = self._ctx.framebuffer([self._ctx.texture(size, 4)])
        return self._target

    def release(self) -> None:
        """Release the target that pictures are drawn into."""
        if self._target is not None:
            for texture in self._target.color_attachments:
                texture.release()
            self._target.release()
        self._target = None


def _placed(seen: Seen, scale: float, size: tuple[int, int]) -> list[PlacedPicture]:
    data, display, clip = seen.data, seen.display, Box(0, 0, *size)
    first = (data.x0 - display.x0) * scale, (data.y0 - display.y0) * scale
    last = (data.x1 - display.x0) * scale, (data.y1 - display.y0) * scale
    seen.texture.sampling = Sampling.LINEAR
    if seen.detail is not None:
        seen.detail.plate.sampling = seen.detail.coarse.sampling = Sampling.LINEAR
    placed = [PlacedPicture(seen.texture, first, last, clip, False, True, seen.detail)]
    if seen.overlay is not None:
        placed.append(PlacedPicture(seen.overlay, first, last, clip, True, False))
    return placed


_REST_S = 0.25  # a picture that is unchanged for this long is sent without loss


# Both are published by the loop that owns the GPU, since no other thread may draw or read a
# texture. A picture is read from the GPU only if some client can take one now: what nobody could
# take when it was new is made up for as soon as one can, see `is_behind`.
class Tap:
    """Publishes state and picture of a session; the loop that owns the GPU calls it."""

    def __init__(self, session: Session, board: Board, shared: SharedSession) -> None:
        self._session = session
        self._shared = shared
        self._page = PageState(session, board)
        self._composed = Composed(session.pictures.renderer.ctx)
        self._key: object = None
        self._changed_at = time.monotonic()

    def publish(self, key: object, look: Callable[[], Seen | None]) -> None:
        """Publish what is new; `look` is asked for the picture `key` only if a page wants it.

        Costs nothing while nobody is connected.
        """
        if not self._shared.clients:
            self._key = None
            return
        self._shared.publish(self._page.now(), self._picture(key, look))

    def key(self, transform_version: int) -> object:
        """Return a key that changes with the picture, under this version of the view transform."""
        facts, scheduler = self._session.facts, self._session.time.scheduler
        view = facts.view.exposed_through(facts.lens)
        return scheduler.picture_key, facts.seen, facts.frame, view, transform_version

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the picture at rest is due; None if it has been sent."""
        now = self._shared.picture
        if not self._shared.clients or now is None or now.is_whole or not self._is_whole:
            return None
        return max(self._changed_at + _REST_S - time.monotonic(), 0.0)

    @property
    def _is_whole(self) -> bool:
        session = self._session
        seen, is_playing = session.facts.seen, session.time.timeline.playback.direction != 0
        is_rendering = session.time.scheduler.is_rendering
        return seen is not None and seen.is_whole and not (is_playing or is_rendering)

    def _picture(self, key: object, look: Callable[[], Seen | None]) -> Picture | None:
        """Return the newest picture, with the last pixels where only the rest is new."""
        last, now = self._shared.picture, time.monotonic()
        self._shared.is_behind = key != self._key and not self._shared.waiting
        if key != self._key and self._shared.waiting:
            seen = look()
            if seen is None:
                return last
            self._key, self._changed_at = key, now
            return self._numbered(self._composed.pixels(seen), False)
        is_resting = key == self._key and now - self._changed_at >= _REST_S and self._is_whole
        if last is not None and is_resting and not last.is_whole:
            return self._numbered(last.pixels, True)
        return last

    def _numbered(self, pixels: Pixels, is_whole: bool) -> Picture:
        last = self._shared.picture
        number = 1 if last is None else last.number + 1
        return Picture(number, self._session.facts.frame, pixels, is_whole)
