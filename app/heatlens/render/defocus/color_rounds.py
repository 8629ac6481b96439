"""Blur once for all colors, or once for each color with a focus of its own."""

from collections.abc import Callable

from heatlens.render.defocus.optics import Color, Optics
from heatlens.render.defocus.plate_passes import ColorPass
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.resources import Texture

# A function that blurs the picture with one focus for all colors.
BlurFunction = Callable[[Optics], Steps[Texture]]


class ColorRounds:
    """Runs a blur once for all colors, or once for each color.

    done, count  how many of all rounds are finished, for reporting progress
    """

    def __init__(self, color_pass: ColorPass) -> None:
        self._pass = color_pass
        self.done, self.count = 0, 1

    def run_once(self, blur_once: BlurFunction, optics: Optics) -> Steps[Texture]:
        """Blur all colors at once."""
        self.done, self.count = 0, 1
        return (yield from blur_once(optics))

    def run_for_each_color(
        self, blur_once: BlurFunction, optics: Optics, size: tuple[int, int], scratch: Scratch
    ) -> Steps[Texture]:
        """Blur with the focus of each color and keep that color; alpha comes with green."""
        red_and_blue = scratch.texture("colours kept", size, 4)
        for done, color in enumerate((Color.RED, Color.BLUE)):
            self.done, self.count = done, 3
            picture = yield from blur_once(optics.in_color(color))
            self._pass.copy_channels(picture, (color,), red_and_blue)
            yield "colours"
        self.done, self.count = 2, 3
        picture = yield from blur_once(optics.in_color(Color.GREEN))
        self._pass.copy_channels(red_and_blue, (Color.RED, Color.BLUE), picture)
        yield scratch.end_pass("colours")
        return picture
