"""What the viewport draws: textures in the colours of the screen, and what they show."""

from dataclasses import dataclass

import moderngl

from heatlens.display.picture_pass import Detail
from heatlens.model.boxes import Box
from heatlens.model.view_geometry import PictureShape
from heatlens.ui.picture.grid import Tile


@dataclass(frozen=True, eq=False)
class Pictures:
    """What the viewport draws."""

    a: moderngl.Texture
    b: moderngl.Texture
    detail: Detail | None  # of A, while that is a hurried picture
    overlay: moderngl.Texture | None
    data_window: Box
    display_window: Box
    pixel_aspect: float
    is_proxy: bool  # A is smaller than the plate: its pixels are no pixels of the picture
    is_b_proxy: bool = False  # and so is B, for the same reason
    has_camera: bool = False  # the right button takes hold of a scene's camera
    has_mipmaps: bool = True  # the textures were made ready to be drawn small
    frame_ratio: float = 1.0  # width of the plate's frame that a lens that breathes shows
    is_a_frame: bool = False  # A is the plate as it lies, of which the lens shows `frame_ratio`
    is_b_frame: bool = False
    light_a: moderngl.Texture | None = None  # scene-linear, pixel for pixel; None: there is none
    light_b: moderngl.Texture | None = None
    light_version: object = None  # equal while the light is the same
    tiles: tuple[Tile, ...] = ()  # of the grid, which then stands in the place of A and B
    names: tuple[str, str] = ("A", "B")  # of both sides of the wipe

    @property
    def shape(self) -> PictureShape:
        """Size and pixel aspect of the display window."""
        window = self.display_window
        return PictureShape(window.width, window.height, self.pixel_aspect)
