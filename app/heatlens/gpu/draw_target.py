"""Keep the framebuffer of the textures that a pass draws into."""

import moderngl


class DrawTarget:
    """Keeps one framebuffer, and makes a new one when the textures change."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._made: tuple[tuple[moderngl.Texture, ...], moderngl.Framebuffer] | None = None

    def around(self, *textures: moderngl.Texture) -> moderngl.Framebuffer:
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


def _are_same(some: tuple[moderngl.Texture, ...], others: tuple[moderngl.Texture, ...]) -> bool:
    return len(some) == len(others) and all(a is b for a, b in zip(some, others, strict=True))
