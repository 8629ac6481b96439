"""Draw the viewport and handle its mouse gestures: zoom, pan, wipe, grid, click to focus."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.orbit import CameraDrag
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Compare, ViewState
from heatlens.core.model.view.view_geometry import (
    PictureShape,
    Point,
    ViewGeometry,
    Viewport,
    desqueezed_shape,
    geometry,
    pan_view,
    zoom_view,
)
from heatlens.render.display.picture_pass import Detail, PicturePass, PlacedPicture
from heatlens.render.display.screen_pictures import MIPMAPS_UNDER
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Sampling, Texture
from heatlens.studio.ui.picture.grid import Pictures, Tile, cell_at, cells, draw_tiles
from heatlens.studio.ui.picture.pixel_values import (
    SideValues,
    draw_display_window,
    draw_pixel_grid,
    draw_wipe_handle,
)

_WHEEL_FACTOR = 1.25  # zoom factor of one wheel notch
_WIPE_REACH_EM = 0.6  # em to either side of the wipe line in which it can be dragged
_SQUARES_FROM_ZOOM = 4.0  # zoom from which pixels are drawn as squares, without filtering


@dataclass(frozen=True)
class ViewportResult:
    """What the user did with the mouse in the picture."""

    view: ViewState
    hovered_px: tuple[int, int] | None  # pixel of the display window under the pointer
    focus_px: tuple[int, int] | None  # pixel to focus on
    camera: CameraDrag | None = None  # movement of a scene's camera
    focus_notches: float = 0.0  # wheel notches with Shift
    tile: int | None = None  # index of the tile that was clicked in the grid


class ViewportPanel:
    """Draws the pictures and handles mouse gestures on them."""

    def __init__(self, ctx: Device, picture_view: PictureView) -> None:
        """Create the panel; it keeps position and zoom of the picture in `picture_view`."""
        self.picture_view = picture_view
        self._pass = PicturePass(ctx)
        self._placed_pictures: list[PlacedPicture] = []
        self._placed_in_frame = -1
        self._values = SideValues(ctx)
        self._gesture: str | None = None  # "pan", "wipe" or "focus" while a button is down
        self._whole = Viewport((0.0, 0.0), (8.0, 8.0))  # the place of all pictures
        self.cells: list[Viewport] = []  # cells of the grid; without grid the viewport alone
        self._hovered_cell: int | None = None  # index of the cell under the pointer

    def take_input(
        self,
        pictures: Pictures,
        view: ViewState,
        framebuffer_scale: float,
        strip_height: float = 0.0,
    ) -> ViewportResult:
        """Fill the current ImGui window with the viewport and handle the mouse; `draw` follows.

        `pictures` are those that the user sees. A strip of `strip_height` screen units stays free
        under the picture.
        """
        corner, size = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
        size = ImVec2(max(size.x, 8.0), max(size.y - strip_height, 8.0))
        self._whole = Viewport((corner.x, corner.y), (size.x, size.y), framebuffer_scale)
        self._split_into_cells(pictures.tiles)
        buttons = imgui.ButtonFlags_
        flags = buttons.mouse_button_left | buttons.mouse_button_middle | buttons.mouse_button_right
        imgui.invisible_button("picture", size, flags)
        camera = self._camera_drag() if pictures.has_camera else None
        tile = self._clicked_tile() if pictures.tiles else None
        focus_px = None
        if camera is None:
            view, focus_px = self._handle_mouse(view, pictures.shape)
        self.picture_view.geometry = geometry(view, self.picture_view.viewport, pictures.shape)
        hovered_px = None
        if imgui.is_item_hovered() or imgui.is_item_active():
            mouse = imgui.get_mouse_pos()
            hovered_px = self.picture_view.geometry.pixel_at_window((mouse.x, mouse.y))
        focus_px = None if pictures.tiles else focus_px
        return ViewportResult(view, hovered_px, focus_px, camera, _focus_notches(), tile)

    @property
    def is_focusing(self) -> bool:
        """True while a drag over the picture moves the focus."""
        return self._gesture == "focus"

    def _split_into_cells(self, tiles: tuple[Tile, ...]) -> None:
        """Divide the viewport among the tiles; `picture_view` gets the cell under the pointer."""
        self.cells = cells(self._whole, len(tiles))
        mouse = imgui.get_mouse_pos()
        self._hovered_cell = cell_at(self.cells, (mouse.x, mouse.y))
        self.picture_view.viewport = self.cells[self._hovered_cell or 0]

    def _clicked_tile(self) -> int | None:
        """Return the tile that was clicked in this frame, or None."""
        is_clicked = imgui.is_item_hovered() and imgui.is_mouse_clicked(imgui.MouseButton_.left)
        return self._hovered_cell if is_clicked else None

    def _camera_drag(self) -> CameraDrag | None:
        """Return the movement of the scene's camera in this frame.

        A right drag orbits around the point in focus, Ctrl+right drag moves sideways, and
        Ctrl+wheel dollies.
        """
        io, height = imgui.get_io(), self.picture_view.viewport.size[1]
        if io.key_ctrl and io.mouse_wheel and imgui.is_item_hovered():
            return CameraDrag("dolly", down=io.mouse_wheel)
        if not (imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.right)):
            return None
        kind: Literal["truck", "orbit"] = "truck" if io.key_ctrl else "orbit"
        return CameraDrag(kind, right=io.mouse_delta.x / height, down=io.mouse_delta.y / height)

    def paint(self, target: Framebuffer, screen_px: tuple[int, int]) -> None:
        """Draw the pictures of this frame; call this before ImGui draws over them."""
        if self._placed_in_frame == imgui.get_frame_count():
            self._pass.run(self._placed_pictures, target, screen_px)

    def place_alone(self, pictures: Pictures, view: ViewState, size_px: tuple[int, int]) -> None:
        """Place the whole picture without overlays in a target of its own, for `paint`.

        A comparison is shown as in the window, but zoom and overlays are ignored.
        """
        fitted_view = replace(view, zoom=None, center_px=None)
        size = float(size_px[0]), float(size_px[1])
        self.cells = cells(Viewport((0.0, 0.0), size), len(pictures.tiles))
        self.picture_view.viewport = self.cells[0]
        self.picture_view.geometry = geometry(
            fitted_view, self.picture_view.viewport, pictures.shape
        )
        self._place_pictures(replace(pictures, overlay=None), fitted_view)

    def place_over(self, pictures: Iterable[PlacedPicture]) -> None:
        """Add pictures over those already placed for `paint`."""
        self._placed_pictures += pictures

    def _handle_mouse(
        self, view: ViewState, shape: PictureShape
    ) -> tuple[ViewState, tuple[int, int] | None]:
        """Handle wheel, pan, wipe and click; return the new view, and the pixel to focus on."""
        io, mouse = imgui.get_io(), imgui.get_mouse_pos()
        pointer = (mouse.x, mouse.y)
        if imgui.is_item_hovered() and io.mouse_wheel and not io.key_shift:
            factor = _WHEEL_FACTOR**io.mouse_wheel
            view = zoom_view(view, self.picture_view.viewport, shape, factor, pointer)
        if not imgui.is_item_active():
            self._gesture = None
            return view, None
        current_geometry = geometry(view, self.picture_view.viewport, shape)
        if self._gesture is None:
            self._gesture = self._gesture_at(view, shape, current_geometry, pointer)
        if self._gesture == "pan":
            movement = (io.mouse_delta.x, io.mouse_delta.y)
            return (
                pan_view(view, self.picture_view.viewport, shape, movement)
                if any(movement)
                else view
            ), None
        if self._gesture == "wipe":
            wipe = current_geometry.picture_at_window(pointer)[0] / shape.width_px
            return replace(view, wipe=min(max(wipe, 0.0), 1.0)), None
        return view, current_geometry.pixel_at_window(pointer)

    def _gesture_at(
        self, view: ViewState, shape: PictureShape, current_geometry: ViewGeometry, pointer: Point
    ) -> str:
        """Return the gesture that a mouse button begins at a position: pan, wipe or focus."""
        if not imgui.is_mouse_down(imgui.MouseButton_.left):
            return "pan"
        reach = _WIPE_REACH_EM * imgui.get_font_size()
        if (
            view.compare is Compare.WIPE
            and abs(pointer[0] - self._wipe_x(view, shape, current_geometry)) <= reach
        ):
            return "wipe"
        return "focus"

    def _wipe_x(
        self, view: ViewState, shape: PictureShape, current_geometry: ViewGeometry
    ) -> float:
        """Return the x of the wipe line in screen units, on a whole screen pixel."""
        scale = self.picture_view.viewport.framebuffer_scale
        x = current_geometry.window_at_picture((view.wipe * shape.width_px, 0.0))[0]
        return math.floor(x * scale + 0.5) / scale

    def draw(self, pictures: Pictures, view: ViewState) -> None:
        """Place the pictures for `paint`, and draw grid, values, wipe and labels over them."""
        self._split_into_cells(pictures.tiles)
        self.picture_view.geometry = geometry(view, self.picture_view.viewport, pictures.shape)
        draw = imgui.get_window_draw_list()
        (x0, y0), (width, height) = self._whole.corner, self._whole.size
        corner, end = ImVec2(x0, y0), ImVec2(x0 + width, y0 + height)
        self._place_pictures(pictures, view)
        if imgui.internal.get_current_window().skip_items:  # the window is hidden
            self._placed_pictures = []
        draw.push_clip_rect(corner, end, True)
        draw_display_window(self.picture_view, pictures)
        if view.pixel_grid and not pictures.tiles:
            draw_pixel_grid(self.picture_view, pictures.shape)
        if view.pixel_values:
            line = self._wipe_x(view, pictures.shape, self.picture_view.geometry)
            self._values.draw(pictures, view.compare, line, self.picture_view)
        if view.compare is Compare.WIPE:
            x = self._wipe_x(view, pictures.shape, self.picture_view.geometry)
            draw_wipe_handle(x, self.picture_view.viewport, pictures.names)
        draw.pop_clip_rect()
        if pictures.tiles:
            draw_tiles(pictures.tiles, self.cells, self._hovered_cell)

    def _place_pictures(self, pictures: Pictures, view: ViewState) -> None:
        """Place A, B or the tiles, as the view compares them, and the overlay."""
        self._placed_pictures, self._placed_in_frame = [], imgui.get_frame_count()
        is_nearest = self.picture_view.zoom >= _SQUARES_FROM_ZOOM or (
            self.picture_view.zoom == 1.0
            and desqueezed_shape(view, pictures.shape).pixel_aspect == 1.0
        )
        clip = self._clip_box()
        is_nearest_b = is_nearest and not pictures.is_b_proxy
        if pictures.tiles:
            self._place_tiles(pictures, view, is_nearest)
        elif view.compare is Compare.FLIP:
            self._place(pictures.b, pictures, is_nearest_b, clip)
        elif view.compare is Compare.WIPE:
            x = self._wipe_x(view, pictures.shape, self.picture_view.geometry)
            line = round(x * self.picture_view.viewport.framebuffer_scale)
            self._place_a(pictures, is_nearest, replace(clip, x1=min(line, clip.x1)))
            right = replace(clip, x0=max(line, clip.x0))
            self._place(pictures.b, pictures, is_nearest_b, right)
            if pictures.is_b_frame:
                self._crop_last_as_lens(pictures, right)
        else:
            self._place_a(pictures, is_nearest, clip)
        is_covered = view.compare in (Compare.FLIP, Compare.GRID)
        if pictures.overlay is not None and not is_covered:
            self._place_overlay(pictures.overlay, pictures, clip)

    def _place_tiles(self, pictures: Pictures, view: ViewState, is_nearest_zoom: bool) -> None:
        """Place each picture of the grid in its cell, all with the same zoom and pan."""
        old_placement = self.picture_view.viewport, self.picture_view.geometry
        for tile, cell in zip(pictures.tiles, self.cells, strict=True):
            self.picture_view.viewport = cell
            self.picture_view.geometry = geometry(view, cell, pictures.shape)
            if tile.texture is not None:
                is_nearest = is_nearest_zoom and not tile.is_proxy
                self._place(tile.texture, pictures, is_nearest, self._clip_box())
        self.picture_view.viewport, self.picture_view.geometry = old_placement

    def _clip_box(self) -> Box:
        """Return the screen pixels of the viewport."""
        (x, y), (width, height) = self.picture_view.viewport.corner, self.picture_view.viewport.size
        scale = self.picture_view.viewport.framebuffer_scale
        x1, y1 = math.floor((x + width) * scale), math.floor((y + height) * scale)
        return Box(math.ceil(x * scale), math.ceil(y * scale), x1, y1)

    def _place_a(self, pictures: Pictures, is_nearest: bool, clip: Box) -> None:
        """Place A with its detail; crop it if it is the whole plate."""
        detail = pictures.detail
        self._place(pictures.a, pictures, is_nearest and not pictures.is_proxy, clip, detail=detail)
        if pictures.is_a_frame:
            self._crop_last_as_lens(pictures, clip)
        if detail is not None:
            self._set_filter(detail.plate, pictures, is_nearest)
            self._set_filter(detail.coarse, pictures, is_nearest=False)

    def _place(
        self,
        texture: Texture,
        pictures: Pictures,
        is_nearest: bool,
        clip: Box,
        is_opaque: bool = True,
        detail: Detail | None = None,
    ) -> None:
        """Place a texture over the data window, for `paint`."""
        self._set_filter(texture, pictures, is_nearest)
        data = pictures.data_window.relative_to(pictures.display_window)
        first = self._screen_point((data.x0, data.y0))
        last = self._screen_point((data.x1, data.y1))
        self._placed_pictures.append(
            PlacedPicture(texture, first, last, clip, is_nearest, is_opaque, detail)
        )

    def _place_overlay(self, overlay: Texture, pictures: Pictures, clip: Box) -> None:
        """Place an overlay of the whole plate, cropped as the lens shows the plate."""
        self._place(overlay, pictures, True, clip, is_opaque=False)
        self._crop_last_as_lens(pictures, clip)

    def _crop_last_as_lens(self, pictures: Pictures, clip: Box) -> None:
        """Enlarge and crop the picture placed last by `frame_ratio`, as the breathing lens does."""
        if pictures.frame_ratio == 1.0:
            return
        last_picture, ratio = self._placed_pictures.pop(), pictures.frame_ratio
        x, y = self._screen_point(pictures.shape.middle_px)
        (x0, y0), (x1, y1) = last_picture.first, last_picture.last
        first = x + (x0 - x) / ratio, y + (y0 - y) / ratio
        last = x + (x1 - x) / ratio, y + (y1 - y) / ratio
        clip = clip.intersection(Box(round(x0), round(y0), round(x1), round(y1)))
        self._placed_pictures.append(replace(last_picture, first=first, last=last, clip=clip))

    def _screen_point(self, point: Point) -> Point:
        """Return where a point of the picture lies, in screen pixels."""
        x, y = self.picture_view.geometry.window_at_picture(point)
        scale = self.picture_view.viewport.framebuffer_scale
        return x * scale, y * scale

    def _set_filter(self, texture: Texture, pictures: Pictures, is_nearest: bool) -> None:
        """Draw texels as squares, or choose mipmaps or linear filtering by their size."""
        texel_px = self.picture_view.zoom * pictures.data_window.height / texture.height
        if is_nearest:
            texture.sampling = Sampling.NEAREST
        elif texel_px < MIPMAPS_UNDER:
            if not pictures.has_mipmaps:
                texture.build_mipmaps()
            texture.sampling = Sampling.MIPMAPPED
        else:
            texture.sampling = Sampling.LINEAR


def _focus_notches() -> float:
    """Return the wheel notches with Shift over the picture, which is the last ImGui item."""
    io = imgui.get_io()
    is_focusing = io.key_shift and not io.key_ctrl and imgui.is_item_hovered()
    return float(io.mouse_wheel) if is_focusing else 0.0
