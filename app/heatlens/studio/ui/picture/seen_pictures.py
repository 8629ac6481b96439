"""Collect the textures that the viewport shows: A, B, overlay and grid, with view transform."""

from dataclasses import replace

from heatlens.core.base.outside_text import printable
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.breathing import plate_ratio
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.look import Look
from heatlens.core.model.view.compared_looks import grid_names, is_look_b, look_named
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.media.plate.overscan_need import overscan_ratio
from heatlens.media.plate.plate import Plate
from heatlens.render.display.picture_pass import Detail
from heatlens.render.display.screen_pictures import MIPMAPS_UNDER, ScreenPictures, picture_of_b
from heatlens.render.gpu.resources import Texture
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.rendered_frames.screen_work import CachedFrame, ScreenWork
from heatlens.studio.board.board import Board
from heatlens.studio.board.controls import PictureControl
from heatlens.studio.ui import texts
from heatlens.studio.ui.picture.grid import Pictures, Tile


class SeenPictures:
    """Prepares the pictures for each frame of the window; unchanged ones are reused."""

    def __init__(
        self,
        board: Board,
        control: PictureControl,
        screen: ScreenPictures,
        cached_screen: ScreenWork,
    ) -> None:
        self._board, self._control, self._screen = board, control, screen
        self._cached_screen = cached_screen

    def collect(self) -> Pictures | None:
        """Return the pictures to show; None while there are none."""
        facts, sides = self._board.facts, self._control.sides
        lens_picture = facts.shown_picture
        if facts.plate is None or lens_picture is None:
            return None
        self._screen.with_mipmaps = self._control.view.zoom < MIPMAPS_UNDER
        plain_view = self._plain_view()
        picture_a = sides.picture_of_a(plain_view) or lens_picture
        view = plain_view.with_transmission(self._lens_of_a(plain_view, picture_a))
        linear_b = self._linear_b(view)
        windows = self._cached_screen.windows(lens_picture) or facts.windows()
        a = self._texture_a(picture_a, view, linear_b)
        b = self._texture_b(view, plain_view, linear_b) or a
        is_of_method = sides.picture_of_b(view) is not None
        light_a, light_b = self._lights(picture_a, view, linear_b, windows[0])
        return Pictures(
            *(
                a,
                b,
                self._detail(picture_a, lens_picture, view),
                self._overlay(view, lens_picture),
                *windows,
            ),
            facts.plate.pixel_aspect_ratio,
            is_proxy=a.size != (windows[0].width, windows[0].height),
            is_b_proxy=is_of_method and b.size != self._control.renderer.loaded.color.size,
            has_camera=facts.has_camera,
            frame_ratio=self._frame_ratio(facts.plate),
            is_a_frame=not (view.depth_of_field or isinstance(picture_a, CachedFrame)),
            is_b_frame=linear_b is self._control.renderer.loaded.color,
            light_a=light_a,
            light_b=light_b,
            light_version=(sides.outputs, facts.plate_version),
            has_mipmaps=self._screen.with_mipmaps,
            tiles=self._grid_tiles(plain_view, a, windows[0].width),
            names=(plain_view.a_look or "now", plain_view.b_look)
            if is_look_b(plain_view)
            else ("A", "B"),
        )

    def pinhole(self) -> Texture:
        """Return the picture without a lens, as the screen shows it."""
        loaded, view = self._control.renderer.loaded, self._board.facts.view
        return self._screen.b(loaded.color, loaded, view.with_transmission(self._board.facts.lens))

    def _plain_view(self) -> ViewState:
        """Return the view, without depth of field while a held key shows the pinhole picture."""
        view, is_held_off = self._board.facts.view, self._control.view.is_lens_held_off
        return replace(view, depth_of_field=view.depth_of_field and not is_held_off)

    def _linear_b(self, view: ViewState) -> Texture:
        """Return the scene-linear texture of B."""
        reference, channel = self._board.facts.reference, self._control.channel
        texture = None if reference is None else reference.texture
        if view.against is Against.CHANNEL:
            texture = channel.texture if channel.is_current else None
        method_picture = self._control.sides.picture_of_b(view)
        return picture_of_b(view, self._control.renderer.loaded, texture, method_picture)

    def _texture_a(self, picture_a: ShownPicture, view: ViewState, linear_b: Texture) -> Texture:
        """Return A in the colors of the screen; a difference needs the linear B."""
        if isinstance(picture_a, CachedFrame):
            return self._cached_screen.texture(picture_a, view)
        key = self._control.sides.outputs, picture_a
        return self._screen.a(picture_a, key, self._control.renderer.loaded, view, linear_b)

    def _texture_b(
        self, view: ViewState, plain_view: ViewState, linear_b: Texture
    ) -> Texture | None:
        """Return B in the colors of the screen; None if B is not shown."""
        if view.compare not in (Compare.WIPE, Compare.FLIP):
            return None
        view_of_b = plain_view.with_transmission(self._lens_of_b(plain_view))
        method_picture = self._control.sides.picture_of_b(view)
        return self._screen.b(linear_b, self._control.renderer.loaded, view_of_b, method_picture)

    def _detail(
        self, picture_a: ShownPicture, lens_picture: ShownPicture, view: ViewState
    ) -> Detail | None:
        """Return the detail of the plate that a smaller picture lacks; None if it lacks none."""
        is_answering, version = self._control.live.is_answering, self._board.facts.plate_version
        is_of_plate = not (is_answering and lens_picture.plate != version)
        has_no_detail = view.compare is Compare.DIFFERENCE or isinstance(picture_a, CachedFrame)
        if not view.depth_of_field or not is_of_plate or has_no_detail:
            return None
        return self._screen.detail(picture_a, self._control.renderer.loaded, view)

    def _lights(
        self, picture_a: ShownPicture, view: ViewState, linear_b: Texture, window: Box
    ) -> tuple[Texture | None, Texture | None]:
        """Return the light of A and of B, each only if it has the size of the plate."""
        plate_size = window.width, window.height
        light = picture_a.texture if view.depth_of_field else self._control.renderer.loaded.color
        is_plate_size = light.size == plate_size and not isinstance(picture_a, CachedFrame)
        return light if is_plate_size else None, linear_b if linear_b.size == plate_size else None

    def _lens_of_a(self, view: ViewState, picture_a: ShownPicture) -> Lens:
        """Return the lens of the picture of A: that of its look, else that of the shot."""
        is_look = self._control.sides.picture_of_a(view) is picture_a
        look = look_named(self._board.facts.shot, view.a_look) if is_look else None
        return self._board.facts.lens if look is None else look.lens

    def _lens_of_b(self, view: ViewState) -> Lens:
        """Return the lens of B: of the shot or the look in it, else the open shot's."""
        picture = self._control.sides.picture_of_b(view)
        if view.against is Against.SHOT and picture is not None:
            return picture.shot.lens_at(picture.frame)
        look = look_named(self._board.facts.shot, view.b_look) if is_look_b(view) else None
        return self._board.facts.lens if look is None else look.lens

    def _overlay(self, view: ViewState, lens_picture: ShownPicture) -> Texture | None:
        """Return the overlay over the picture; None if none is shown."""
        facts = self._board.facts
        if not view.has_overlay or not facts.has_lens:
            return None
        shot, frame = facts.seen_shot, facts.frame
        loaded = self._control.renderer.loaded
        return self._screen.overlay(
            loaded, shot, frame, view, self._cached_screen.upload(lens_picture)
        )

    def _frame_ratio(self, plate: Plate) -> float:
        """Return the share of a plate's frame in view; 1 for a scene, which is drawn as framed."""
        if self._board.facts.has_camera:
            return 1.0
        return plate_ratio(self._board.facts.lens, overscan_ratio(plate))

    def _grid_tiles(self, view: ViewState, a: Texture, width: int) -> tuple[Tile, ...]:
        """Return the pictures of the grid; nothing if the grid is not shown."""
        if view.compare is not Compare.GRID:
            self._screen.keep_tiles(())
            return ()
        names = grid_names(view, self._board.facts.shot)
        self._screen.keep_tiles(names)
        looks = [look_named(self._board.facts.shot, name) for name in names]
        now = f"now   {self._lens_words(self._board.facts.lens)}"
        return tuple(
            Tile(name="", words=now, texture=a, is_proxy=a.width != width, is_current_lens=False)
            if look is None
            else self._look_tile(look, view, width)
            for look in looks
        )

    def _look_tile(self, look: Look, view: ViewState, width: int) -> Tile:
        """Return the tile of a look; `width` is that of the whole picture in pixels."""
        sides = self._control.sides
        picture = sides.picture_of_look(look.name)
        words = f"{look.name}   {self._lens_words(look.lens)}"
        is_current_lens = self._board.facts.lens == look.lens
        if picture is None:
            words += "   rendering ..."
        elif sides.is_unfinished(look.name):
            words += "   preview, rendering ..."
        if picture is None:
            return Tile(
                look.name, printable(words), None, is_proxy=False, is_current_lens=is_current_lens
            )
        texture = self._screen.tile(look.name, picture, view.with_transmission(look.lens))
        return Tile(look.name, printable(words), texture, texture.width != width, is_current_lens)

    def _lens_words(self, lens: Lens) -> str:
        """Return focal length, f-stop and focus distance in short."""
        distance = texts.measured_label(lens, lens.focus_distance_m, self._board.facts.view.unit)
        return f"{lens.focal_length_mm:.4g} mm  f/{lens.f_stop:.3g}  at {distance}"
