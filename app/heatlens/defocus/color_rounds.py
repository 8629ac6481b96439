"""Blur the three colours one after the other, for a lens with axial colour.

Such a lens focuses each colour at a different distance, so that each needs its own blur.
"""

from collections.abc import Callable

import moderngl

from heatlens.defocus.optics import Color, Optics
from heatlens.defocus.plate_passes import ColorPass
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.steps import Steps

# Blurs the picture with one focus for all colours.
Blurred = Callable[[Optics], Steps[moderngl.Texture]]


class ColorRounds:
    """Runs a blur once, or once for each colour; `done` of `count` rounds are finished."""

    def __init__(self, color_pass: ColorPass) -> None:
        self._pass = color_pass
        self.done, self.count = 0, 1

    def in_one(self, blurred: Blurred, optics: Optics) -> Steps[moderngl.Texture]:
        """Blur all colours at once."""
        self.done, self.count = 0, 1
        return (yield from blurred(optics))

    def in_three(
        self, blurred: Blurred, optics: Optics, size: tuple[int, int], scratch: Scratch
    ) -> Steps[moderngl.Texture]:
        """Blur with the focus of each colour and keep that colour; alpha comes with green."""
        kept = scratch.texture("colours kept", size, 4)
        for done, color in enumerate((Color.RED, Color.BLUE)):
            self.done, self.count = done, 3
            picture = yield from blurred(optics.in_color(color))
            self._pass.take(picture, (color,), kept)
            yield "colours"
        self.done, self.count = 2, 3
        picture = yield from blurred(optics.in_color(Color.GREEN))
        self._pass.take(kept, (Color.RED, Color.BLUE), picture)
        yield scratch.passed("colours")
        return picture
