"""Draw the viewport and handle its mouse gestures: zoom, pan, wipe, grid, click to focus."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

from imgui_bundle import ImVec2, imgui

from heatlens.core.model.boxes import Box
from heatlens.core.model.view.view import Compare, ViewState
from heatlens.core.model.view.view_geometry import (
    PictureShape,
    Point,
    ViewGeometry,
    Viewport,
    geometry,
    panned,
    shown_shape,
    zoomed,
)
from heatlens.render.display.picture_pass import Detail, PicturePass, PlacedPicture
from heatlens.render.display.screen_pictures import MIPMAPS_UNDER
from heatlens.render.gpu.device import Device, Framebuffer, Sampling, Texture
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.session.scenes.scene_commands import CameraDrag
from heatlens.studio.ui.picture.grid import Pictures, Tile, cell_at, cells, draw_tiles
from heatlens.studio.ui.picture.pixel_values import (
    SideValues,
    draw_display_window,
    draw_pixel_grid,
    draw_wipe_handle,
)

_WHEEL_FACTOR = 1.25  # zoom factor of one wheel notch
_HANDLE_REACH = 0.6  # em to either side of the wipe line in which it can be dragged
_NEAREST_FROM = 4.0  # zoom from which pixels are drawn as squares, without filtering


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

    def __init__(self, ctx: Device, place: PictureView) -> None:
        """Create the panel; it keeps position and zoom of the picture in `place`."""
        self.place = place
        self._pass = PicturePass(ctx)
        self._placed: list[PlacedPicture] = []
        self._placed_in_frame = -1
        self._values = SideValues(ctx)
        self._gesture: str | None = None  # "pan", "wipe" or "focus" while a button is down
        self.cells: list[Viewport] = []  # cells of the grid; without grid the viewport alone
        self._cell_under: int | None = None  # index of the cell under the pointer

    def draw(
        self, pictures: Pictures, view: ViewState, framebuffer_scale: float, below: float = 0.0
    ) -> ViewportResult:
        """Fill the current ImGui window with the picture and handle the mouse.

        A strip of the height `below` stays free under the picture.
        """
        corner, size = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
        size = ImVec2(max(size.x, 8.0), max(size.y - below, 8.0))
        self._split(
            Viewport((corner.x, corner.y), (size.x, size.y), framebuffer_scale), pictures.tiles
        )
        buttons = imgui.ButtonFlags_
        flags = buttons.mouse_button_left | buttons.mouse_button_middle | buttons.mouse_button_right
        imgui.invisible_button("picture", size, flags)
        camera = self._camera_drag() if pictures.has_camera else None
        tile = self._clicked_tile() if pictures.tiles else None
        focus_px = None
        if camera is None:
            view, focus_px = self._answer_mouse(view, pictures.shape)
        self.place.geometry = geometry(view, self.place.viewport, pictures.shape)
        self._draw(pictures, view, corner, size)
        hovered = None
        if imgui.is_item_hovered() or imgui.is_item_active():
            mouse = imgui.get_mouse_pos()
            hovered = self.place.geometry.pixel_at_window((mouse.x, mouse.y))
        focus_px = None if pictures.tiles else focus_px
        return ViewportResult(view, hovered, focus_px, camera, _focus_notches(), tile)

    @property
    def is_focusing(self) -> bool:
        """True while a drag over the picture moves the focus."""
        return self._gesture == "focus"

    def _split(self, whole: Viewport, tiles: tuple[Tile, ...]) -> None:
        """Divide the viewport among the tiles; `place` is the cell under the pointer."""
        self.cells = cells(whole, len(tiles))
        mouse = imgui.get_mouse_pos()
        self._cell_under = cell_at(self.cells, (mouse.x, mouse.y))
        self.place.viewport = self.cells[self._cell_under or 0]

    def _clicked_tile(self) -> int | None:
        is_clicked = imgui.is_item_hovered() and imgui.is_mouse_clicked(imgui.MouseButton_.left)
        return self._cell_under if is_clicked else None

    def _camera_drag(self) -> CameraDrag | None:
        """Return the movement of the scene's camera in this frame.

        A right drag orbits around the point in focus, Ctrl+right drag moves sideways, and
        Ctrl+wheel dollies.
        """
        io, height = imgui.get_io(), self.place.viewport.size[1]
        if io.key_ctrl and io.mouse_wheel and imgui.is_item_hovered():
            return CameraDrag("dolly", down=io.mouse_wheel)
        if not (imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.right)):
            return None
        kind: Literal["truck", "orbit"] = "truck" if io.key_ctrl else "orbit"
        return CameraDrag(kind, io.mouse_delta.x / height, io.mouse_delta.y / height)

    def paint(self, target: Framebuffer, screen_px: tuple[int, int]) -> None:
        """Draw the pictures of this frame; call this before ImGui draws over them."""
        if self._placed_in_frame == imgui.get_frame_count():
            self._pass.run(self._placed, target, screen_px)

    def place_alone(self, pictures: Pictures, view: ViewState, size_px: tuple[int, int]) -> None:
        """Place the whole picture without overlays in a target of its own, for `paint`.

        A comparison is shown as in the window, but zoom and overlays are ignored.
        """
        whole = replace(view, zoom=None, center_px=None)
        size = float(size_px[0]), float(size_px[1])
        self.cells = cells(Viewport((0.0, 0.0), size), len(pictures.tiles))
        self.place.viewport = self.cells[0]
        self.place.geometry = geometry(whole, self.place.viewport, pictures.shape)
        self._place_pictures(replace(pictures, overlay=None), whole)

    def place_over(self, placed: Iterable[PlacedPicture]) -> None:
        """Add pictures over those already placed for `paint`."""
        self._placed += placed

    def _answer_mouse(
        self, view: ViewState, shape: PictureShape
    ) -> tuple[ViewState, tuple[int, int] | None]:
        io, mouse = imgui.get_io(), imgui.get_mouse_pos()
        at = (mouse.x, mouse.y)
        if imgui.is_item_hovered() and io.mouse_wheel and not io.key_shift:
            factor = _WHEEL_FACTOR**io.mouse_wheel
            view = zoomed(view, self.place.viewport, shape, factor, at)
        if not imgui.is_item_active():
            self._gesture = None
            return view, None
        now = geometry(view, self.place.viewport, shape)
        if self._gesture is None:
            self._gesture = self._gesture_at(view, shape, now, at)
        if self._gesture == "pan":
            by = (io.mouse_delta.x, io.mouse_delta.y)
            return (panned(view, self.place.viewport, shape, by) if any(by) else view), None
        if self._gesture == "wipe":
            wipe = now.picture_at_window(at)[0] / shape.width_px
            return replace(view, wipe=min(max(wipe, 0.0), 1.0)), None
        return view, now.pixel_at_window(at)

    def _gesture_at(
        self, view: ViewState, shape: PictureShape, now: ViewGeometry, at: Point
    ) -> str:
        """Return the gesture that a mouse button begins at a position: pan, wipe or focus."""
        if not imgui.is_mouse_down(imgui.MouseButton_.left):
            return "pan"
        reach = _HANDLE_REACH * imgui.get_font_size()
        if view.compare is Compare.WIPE and abs(at[0] - self._wipe_x(view, shape, now)) <= reach:
            return "wipe"
        return "focus"

    def _wipe_x(self, view: ViewState, shape: PictureShape, now: ViewGeometry) -> float:
        """Return the x of the wipe line in screen units, on a whole screen pixel."""
        scale = self.place.viewport.framebuffer_scale
        x = now.window_at_picture((view.wipe * shape.width_px, 0.0))[0]
        return math.floor(x * scale + 0.5) / scale

    def _draw(self, pictures: Pictures, view: ViewState, corner: ImVec2, size: ImVec2) -> None:
        draw = imgui.get_window_draw_list()
        end = ImVec2(corner.x + size.x, corner.y + size.y)
        self._place_pictures(pictures, view)
        if imgui.internal.get_current_window().skip_items:  # the window is hidden
            self._placed = []
        draw.push_clip_rect(corner, end, True)
        draw_display_window(self.place, pictures)
        if view.pixel_grid and not pictures.tiles:
            draw_pixel_grid(self.place, pictures.shape)
        if view.pixel_values:
            line = self._wipe_x(view, pictures.shape, self.place.geometry)
            self._values.draw(pictures, view.compare, line, self.place)
        if view.compare is Compare.WIPE:
            x = self._wipe_x(view, pictures.shape, self.place.geometry)
            draw_wipe_handle(x, self.place.viewport, pictures.names)
        draw.pop_clip_rect()
        if pictures.tiles:
            draw_tiles(pictures.tiles, self.cells, self._cell_under)

    def _place_pictures(self, pictures: Pictures, view: ViewState) -> None:
        self._placed, self._placed_in_frame = [], imgui.get_frame_count()
        near = self.place.zoom >= _NEAREST_FROM or (
            self.place.zoom == 1.0 and shown_shape(view, pictures.shape).pixel_aspect == 1.0
        )
        clip = self._clip()
        near_b = near and not pictures.is_b_proxy
        if pictures.tiles:
            self._place_tiles(pictures, view, near)
        elif view.compare is Compare.FLIP:
            self._place(pictures.b, pictures, near_b, clip)
        elif view.compare is Compare.WIPE:
            x = self._wipe_x(view, pictures.shape, self.place.geometry)
            line = round(x * self.place.viewport.framebuffer_scale)
            self._place_a(pictures, near, replace(clip, x1=min(line, clip.x1)))
            right = replace(clip, x0=max(line, clip.x0))
            self._place(pictures.b, pictures, near_b, right)
            if pictures.is_b_frame:
                self._show_as_the_lens(pictures, right)
        else:
            self._place_a(pictures, near, clip)
        is_covered = view.compare in (Compare.FLIP, Compare.GRID)
        if pictures.overlay is not None and not is_covered:
            self._place_overlay(pictures.overlay, pictures, clip)

    def _place_tiles(self, pictures: Pictures, view: ViewState, near: bool) -> None:
        """Place each picture of the grid in its cell, all with the same zoom and pan."""
        before = self.place.viewport, self.place.geometry
        for tile, cell in zip(pictures.tiles, self.cells, strict=True):
            self.place.viewport = cell
            self.place.geometry = geometry(view, cell, pictures.shape)
            if tile.texture is not None:
                is_nearest = near and not tile.is_proxy
                self._place(tile.texture, pictures, is_nearest, self._clip())
        self.place.viewport, self.place.geometry = before

    def _clip(self) -> Box:
        (x, y), (width, height) = self.place.viewport.corner, self.place.viewport.size
        scale = self.place.viewport.framebuffer_scale
        x1, y1 = math.floor((x + width) * scale), math.floor((y + height) * scale)
        return Box(math.ceil(x * scale), math.ceil(y * scale), x1, y1)

    def _place_a(self, pictures: Pictures, near: bool, clip: Box) -> None:
        detail = pictures.detail
        self._place(pictures.a, pictures, near and not pictures.is_proxy, clip, detail=detail)
        if pictures.is_a_frame:
            self._show_as_the_lens(pictures, clip)
        if detail is not None:
            self._set_filter(detail.plate, pictures, near)
            self._set_filter(detail.coarse, pictures, False)

    def _place(
        self,
        texture: Texture,
        pictures: Pictures,
        is_nearest: bool,
        clip: Box,
        is_opaque: bool = True,
        detail: Detail | None = None,
    ) -> None:
        self._set_filter(texture, pictures, is_nearest)
        data, display = pictures.data_window, pictures.display_window
        first = self._screen_at((data.x0 - display.x0, data.y0 - display.y0))
        last = self._screen_at((data.x1 - display.x0, data.y1 - display.y0))
        self._placed.append(
            PlacedPicture(texture, first, last, clip, is_nearest, is_opaque, detail)
        )

    def _place_overlay(self, overlay: Texture, pictures: Pictures, clip: Box) -> None:
        """Place an overlay of the whole plate, cropped as the lens shows the plate."""
        self._place(overlay, pictures, True, clip, is_opaque=False)
        self._show_as_the_lens(pictures, clip)

    def _show_as_the_lens(self, pictures: Pictures, clip: Box) -> None:
        """Enlarge and crop the picture placed last by `frame_ratio`, as the breathing lens does."""
        if pictures.frame_ratio == 1.0:
            return
        whole, ratio = self._placed.pop(), pictures.frame_ratio
        x, y = self._screen_at(pictures.shape.middle_px)
        (x0, y0), (x1, y1) = whole.first, whole.last
        first = x + (x0 - x) / ratio, y + (y0 - y) / ratio
        last = x + (x1 - x) / ratio, y + (y1 - y) / ratio
        clip = clip.intersection(Box(round(x0), round(y0), round(x1), round(y1)))
        self._placed.append(replace(whole, first=first, last=last, clip=clip))

    def _screen_at(self, point: Point) -> Point:
        x, y = self.place.geometry.window_at_picture(point)
        scale = self.place.viewport.framebuffer_scale
        return x * scale, y * scale

    def _set_filter(self, texture: Texture, pictures: Pictures, nearest: bool) -> None:
        texels = self.place.zoom * pictures.data_window.height / texture.height
        if nearest:
            texture.sampling = Sampling.NEAREST
        elif texels < MIPMAPS_UNDER:
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
