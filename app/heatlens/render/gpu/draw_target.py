"""Keep the framebuffers of the textures that are drawn into, with or without a depth buffer."""

from dataclasses import dataclass

from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import DepthBuffer, Texture

_TARGETS_MAX = 10  # framebuffers that are kept


class DrawTarget:
    """Keeps one framebuffer, and makes a new one when the textures change."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._cached: tuple[tuple[Texture, ...], Framebuffer] | None = None

    def around(self, *textures: Texture) -> Framebuffer:
        """Return the framebuffer that draws into `textures`, the first one as output 0.

        The old one is released last: moderngl would bind the window's framebuffer in its place, and
        a headless context has none.
        """
        previous = self._cached
        if previous is not None and _are_same(previous[0], textures):
            return previous[1]
        framebuffer = self._ctx.framebuffer(list(textures))
        framebuffer.use()
        self._cached = textures, framebuffer
        if previous is not None:
            previous[1].release()
        return framebuffer


def _are_same(textures: tuple[Texture, ...], other_textures: tuple[Texture, ...]) -> bool:
    """Return True if both hold the same textures, not equal ones, in the same order."""
    return len(textures) == len(other_textures) and all(
        a is b for a, b in zip(textures, other_textures, strict=True)
    )


@dataclass(frozen=True, eq=False)
class Target:
    """A framebuffer and the depth buffer that was made for it."""

    framebuffer: Framebuffer
    depth: DepthBuffer

    def release(self) -> None:
        """Release both, which must not be bound."""
        self.framebuffer.release()
        self.depth.release()


class DrawTargets:
    """Framebuffers by texture; only the latest few are kept."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._targets: list[tuple[Texture, Target]] = []
        # Bound while other framebuffers are released; moderngl would bind that of the window, which
        # may not exist.
        self._fallback = ctx.simple_framebuffer((1, 1))

    def of(self, texture: Texture) -> Framebuffer:
        """Return a framebuffer that draws into `texture`."""
        for index, (target_texture, target) in enumerate(self._targets):
            if target_texture is texture:
                self._targets.append(self._targets.pop(index))
                return target.framebuffer
        self._release_oldest(_TARGETS_MAX - 1)
        depth = self._ctx.depth_buffer(texture.size)
        target = Target(self._ctx.framebuffer([texture], depth), depth)
        self._targets.append((texture, target))
        return target.framebuffer

    def _release_oldest(self, count_max: int) -> None:
        """Release all but the latest `count_max` targets, and those whose texture was released."""
        latest = [entry for entry in self._targets if not entry[0].is_released]
        latest = latest[len(latest) - count_max :] if len(latest) > count_max else latest
        outdated = [
            entry[1] for entry in self._targets if all(entry is not other for other in latest)
        ]
        self._targets = latest
        if outdated:
            self._fallback.use()
        for target in outdated:
            target.release()

    def release(self) -> None:
        """Release all framebuffers but the one that stays bound."""
        self._release_oldest(0)
        self._fallback.use()
