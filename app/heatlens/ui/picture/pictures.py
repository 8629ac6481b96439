"""Define the set of display-ready textures that the viewport draws."""

from dataclasses import dataclass

import moderngl

from heatlens.display.picture_pass import Detail
from heatlens.model.boxes import Box
from heatlens.model.view.view_geometry import PictureShape
from heatlens.ui.picture.grid import Tile


@dataclass(frozen=True, eq=False)
class Pictures:
    """The textures that the viewport draws, and facts about them."""

    a: moderngl.Texture
    b: moderngl.Texture
    detail: Detail | None  # sharpens A while it is a preview
    overlay: moderngl.Texture | None
    data_window: Box
    display_window: Box
    pixel_aspect: float
    is_proxy: bool  # A has fewer pixels than the plate
    is_b_proxy: bool = False  # B has fewer pixels than the plate
    has_camera: bool = False  # the right mouse button moves the camera of a scene
    has_mipmaps: bool = True  # the textures have mipmaps for drawing them small
    frame_ratio: float = 1.0  # share of the plate's width in view, below 1 if the lens breathes
    is_a_frame: bool = False  # A is the whole plate, still to be cropped by `frame_ratio`
    is_b_frame: bool = False
    light_a: moderngl.Texture | None = None  # scene-linear values of A; None if not available
    light_b: moderngl.Texture | None = None
    light_version: object = None  # changes with the scene-linear values
    tiles: tuple[Tile, ...] = ()  # the grid, shown instead of A and B
    names: tuple[str, str] = ("A", "B")  # labels of the two sides of the wipe

    @property
    def shape(self) -> PictureShape:
        """Size and pixel aspect of the display window."""
        window = self.display_window
        return PictureShape(window.width, window.height, self.pixel_aspect)
