"""Publish the state and the picture of a session to its pages.

A picture is composed as the window shows it and read from the GPU, whenever it is new and a page
can take it.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from heatlens.core.model.boxes import Box
from heatlens.render.display.picture_pass import Detail, PicturePass, PlacedPicture
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Sampling, Texture
from heatlens.studio.board.board import Board
from heatlens.studio.board.session import Session
from heatlens.studio.share.picture import Picture, Pixels, crop_to_display
from heatlens.studio.share.shared import SharedSession

# Previews are limited in width, because drawing one must not delay the next one. At full size,
# drawing and reading previews took over half of the loop at 720p on a processor without a GPU, most
# of it for pixels that a preview does not have. The picture at rest keeps its full size.
_PREVIEW_PX = 720  # largest width of a preview


@dataclass(frozen=True, eq=False)
class DisplayedPicture:
    """A picture in display values, its detail and overlay, and its data and display windows."""

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


class PictureComposer:
    """Draws pictures as pages show them, and reads their pixels from the GPU."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._pass = PicturePass(ctx)
        self._target: Framebuffer | None = None

    def read_pixels(self, picture: DisplayedPicture) -> Pixels:
        """Return the pixels of the display window, (H, W, 4), the top row first."""
        if picture.is_bare:
            pixels = np.empty((picture.texture.height, picture.texture.width, 4), np.uint8)
            picture.texture.read_into(pixels.data.cast("B"))
            return crop_to_display(pixels, picture.data, picture.display)
        scale = 1.0 if picture.detail is None else min(1.0, _PREVIEW_PX / picture.display.width)
        size = (
            max(1, round(picture.display.width * scale)),
            max(1, round(picture.display.height * scale)),
        )
        target = self._target_of_size(size)
        target.use()
        target.clear(0.0, 0.0, 0.0, 1.0)
        self._pass.run(_picture_layers(picture, scale, size), target, size)
        pixels = np.empty((size[1], size[0], 4), np.uint8)
        target.read_into(pixels.data.cast("B"), components=4)
        return pixels[::-1]

    def _target_of_size(self, size: tuple[int, int]) -> Framebuffer:
        """Return the framebuffer, made anew if its size changes."""
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


def _picture_layers(
    picture: DisplayedPicture, scale: float, size: tuple[int, int]
) -> list[PlacedPicture]:
    """Return the picture, and the overlay if there is one, at their places in the target."""
    data, clip = picture.data.relative_to(picture.display), Box(0, 0, *size)
    top_left = data.x0 * scale, data.y0 * scale
    bottom_right = data.x1 * scale, data.y1 * scale
    picture.texture.sampling = Sampling.LINEAR
    if picture.detail is not None:
        picture.detail.plate.sampling = picture.detail.coarse.sampling = Sampling.LINEAR
    layers = [
        PlacedPicture(
            picture.texture,
            first=top_left,
            last=bottom_right,
            clip=clip,
            is_nearest=False,
            is_opaque=True,
            detail=picture.detail,
        )
    ]
    if picture.overlay is not None:
        layers.append(
            PlacedPicture(
                picture.overlay, top_left, bottom_right, clip, is_nearest=True, is_opaque=False
            )
        )
    return layers


_REST_S = 0.25  # a picture that is unchanged for this long is sent without loss


# The loop that owns the GPU publishes state and picture, since no other thread may draw or read a
# texture. A picture is read from the GPU only if some client can take one now. If no client could
# take it when it was new, it is read as soon as one can, see `is_behind`.
class SessionPublisher:
    """Publishes state and picture of a session; the loop that owns the GPU calls it."""

    def __init__(self, session: Session, board: Board, shared: SharedSession) -> None:
        self._shared = shared
        self._board = board
        self._composer = PictureComposer(session.pictures.renderer.ctx)
        self._key: object = None  # the key of the last picture that was read; None for none
        self._changed_at = time.monotonic()  # when the last picture was read, in seconds

    def publish(self, key: object, make_picture: Callable[[], DisplayedPicture | None]) -> None:
        """Publish new state, and a picture if there is a new one.

        `key` changes whenever the picture changes; the same key does not make the picture again.
        `make_picture` is called only if a page can take the picture. Nothing is done while no page
        is connected.
        """
        if not self._shared.client_count:
            self._key = None  # the next page to connect needs a new picture
            return
        self._shared.publish(self._board.json_state(), self._newest_picture(key, make_picture))

    def key(self, transform_version: int) -> object:
        """Return a key that changes with the picture, under this version of the view transform."""
        facts = self._board.facts
        view = facts.view.with_transmission(facts.lens)
        return facts.picture, facts.shown_picture, facts.frame, view, transform_version

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until the picture at rest is due; None if it has been sent."""
        picture = self._shared.picture
        if (
            not self._shared.client_count
            or picture is None
            or picture.is_whole
            or not self._is_final
        ):
            return None
        return max(self._changed_at + _REST_S - time.monotonic(), 0.0)

    @property
    def _is_final(self) -> bool:
        """True if the picture is finished, and neither playback nor rendering will change it."""
        facts = self._board.facts
        return facts.is_whole and facts.direction == 0

    def _newest_picture(
        self, key: object, make_picture: Callable[[], DisplayedPicture | None]
    ) -> Picture | None:
        """Return the newest picture for the pages, or the last one if nothing is new.

        Once the picture rests, the last pixels are returned again with the next number, marked as
        whole. Return None if there was no picture yet.
        """
        last, now = self._shared.picture, time.monotonic()
        self._shared.is_behind = key != self._key and not self._shared.ready_clients
        if key != self._key and self._shared.ready_clients:
            picture = make_picture()
            if picture is None:
                return last
            self._key, self._changed_at = key, now
            return self._number_picture(self._composer.read_pixels(picture), is_whole=False)
        is_resting = key == self._key and now - self._changed_at >= _REST_S and self._is_final
        if last is not None and is_resting and not last.is_whole:
            return self._number_picture(last.pixels, is_whole=True)
        return last

    def _number_picture(self, pixels: Pixels, is_whole: bool) -> Picture:
        """Return pixels as the picture of the current frame, with the next number."""
        last = self._shared.picture
        number = 1 if last is None else last.number + 1
        facts = self._board.facts
        lens_number = facts.lens_number if facts.shows_lens else 0
        return Picture(number, facts.frame, pixels, is_whole, lens_number)
