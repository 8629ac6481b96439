"""Keep the framebuffers of the textures that are drawn into, with or without a depth buffer."""

from dataclasses import dataclass

from heatlens.render.gpu.device import DepthBuffer, Device, Framebuffer, Texture

_MOST_KEPT = 10


class DrawTarget:
    """Keeps one framebuffer, and makes a new one when the textures change."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._made: tuple[tuple[Texture, ...], Framebuffer] | None = None

    def around(self, *textures: Texture) -> Framebuffer:
        """Return the framebuffer that draws into `textures`, the first one as output 0.

        The old one is released last: moderngl would bind the window's framebuffer in its place, and
        a headless context has none.
        """
        before = self._made
        if before is not None and _are_same(before[0], textures):
            return before[1]
        framebuffer = self._ctx.framebuffer(list(textures))
        framebuffer.use()
        self._made = textures, framebuffer
        if before is not None:
            before[1].release()
        return framebuffer


def _are_same(some: tuple[Texture, ...], others: tuple[Texture, ...]) -> bool:
    return len(some) == len(others) and all(a is b for a, b in zip(some, others, strict=True))


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
        self._kept: list[tuple[Texture, Target]] = []
        # Bound when the others are released; moderngl would bind the window's, which may not exist.
        self._rest = ctx.simple_framebuffer((1, 1))

    def of(self, texture: Texture) -> Framebuffer:
        """Return a framebuffer that draws into `texture`."""
        for place, (held, target) in enumerate(self._kept):
            if held is texture:
                self._kept.append(self._kept.pop(place))
                return target.framebuffer
        self._let_go(_MOST_KEPT - 1)
        depth = self._ctx.depth_buffer(texture.size)
        target = Target(self._ctx.framebuffer([texture], depth), depth)
        self._kept.append((texture, target))
        return target.framebuffer

    def _let_go(self, most: int) -> None:
        """Release all but the latest `most`, and those whose texture was released."""
        kept = [entry for entry in self._kept if not entry[0].is_released]
        kept = kept[len(kept) - most :] if len(kept) > most else kept
        gone = [entry[1] for entry in self._kept if all(entry is not other for other in kept)]
        self._kept = kept
        if gone:
            self._rest.use()
        for target in gone:
            target.release()

    def release(self) -> None:
        """Release all framebuffers but the one that stays bound."""
        self._let_go(0)
        self._rest.use()
