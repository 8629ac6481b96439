"""Collect the textures that the viewport shows: A, B, overlay and grid, with view transform."""

from dataclasses import replace

from heatlens.core.base.outside_text import printable
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.breathing import plate_ratio
from heatlens.core.model.lens.lens import Lens, measured_text
from heatlens.core.model.shot.look import Look
from heatlens.core.model.view.view import Compare, ViewState
from heatlens.media.plate.overscan_need import room_of
from heatlens.media.plate.plate import Plate
from heatlens.render.display.picture_pass import Detail
from heatlens.render.display.screen_pictures import MIPMAPS_UNDER, ScreenPictures, picture_of_b
from heatlens.render.gpu.device import Texture
from heatlens.render.preview.shown import Shown
from heatlens.studio.session.desks import PictureDesk
from heatlens.studio.session.facts import Facts
from heatlens.studio.session.pictures.compare_sides import grid_names, is_look_b, look_called
from heatlens.studio.session.playing.kept_screen import KeptFrame, KeptScreen
from heatlens.studio.ui.picture.grid import Pictures, Tile


class SeenPictures:
    """Prepares the pictures for each frame of the window; unchanged ones are reused."""

    def __init__(
        self, facts: Facts, desk: PictureDesk, screen: ScreenPictures, kept: KeptScreen
    ) -> None:
        self._facts, self._desk, self._screen = facts, desk, screen
        self._kept = kept

    def now(self) -> Pictures | None:
        """Return the pictures to show; None while there are none."""
        facts, sides, seen = self._facts, self._desk.sides, self._facts.seen
        if facts.plate is None or seen is None:
            return None
        self._screen.with_mipmaps = self._desk.view.zoom < MIPMAPS_UNDER
        plain = self._plain_view()
        shown = sides.of_a(plain) or seen
        view = plain.exposed_through(self._lens_of_a(plain, shown))
        linear_b = self._linear_b(view)
        windows = self._kept.windows(seen) or facts.windows()
        a = self._a(shown, view, linear_b)
        b = self._b(view, plain, linear_b) or a
        is_of_method = sides.of_method(view) is not None
        light_a, light_b = self._lights(shown, view, linear_b, windows[0])
        return Pictures(
            *(a, b, self._detail(shown, seen, view), self._overlay(view, seen), *windows),
            facts.plate.pixel_aspect_ratio,
            is_proxy=a.size != (windows[0].width, windows[0].height),
            is_b_proxy=is_of_method and b.size != self._desk.renderer.loaded.color.size,
            has_camera=facts.has_camera,
            frame_ratio=self._frame_ratio(facts.plate),
            is_a_frame=not (view.depth_of_field or isinstance(shown, KeptFrame)),
            is_b_frame=linear_b is self._desk.renderer.loaded.color,
            light_a=light_a,
            light_b=light_b,
            light_version=(sides.pictures, facts.plate_version),
            has_mipmaps=self._screen.with_mipmaps,
            tiles=self._tiles(plain, a, windows[0].width),
            names=(plain.a_look or "now", plain.b_look) if is_look_b(plain) else ("A", "B"),
        )

    def pinhole(self) -> Texture:
        """Return the picture without a lens, as the screen shows it."""
        loaded, view = self._desk.renderer.loaded, self._facts.view
        return self._screen.b(loaded.color, loaded, view.exposed_through(self._facts.lens))

    def _plain_view(self) -> ViewState:
        """Return the view, without depth of field while a held key shows the pinhole picture."""
        view, is_held_off = self._facts.view, self._desk.view.is_lens_held_off
        return replace(view, depth_of_field=view.depth_of_field and not is_held_off)

    def _linear_b(self, view: ViewState) -> Texture:
        reference, of_method = self._facts.reference, self._desk.sides.of_method(view)
        texture = None if reference is None else reference.texture
        return picture_of_b(view, self._desk.renderer.loaded, texture, of_method)

    def _a(self, shown: Shown, view: ViewState, linear_b: Texture) -> Texture:
        if isinstance(shown, KeptFrame):
            return self._kept.texture(shown, view)
        key = self._desk.sides.pictures, shown
        return self._screen.a(shown, key, self._desk.renderer.loaded, view, linear_b)

    def _b(self, view: ViewState, plain: ViewState, linear_b: Texture) -> Texture | None:
        """Return B as the screen shows it; None if it is not shown."""
        if view.compare not in (Compare.WIPE, Compare.FLIP):
            return None
        view_of_b = plain.exposed_through(self._lens_of_b(plain))
        of_method = self._desk.sides.of_method(view)
        return self._screen.b(linear_b, self._desk.renderer.loaded, view_of_b, of_method)

    def _detail(self, shown: Shown, seen: Shown, view: ViewState) -> Detail | None:
        """Return the detail of the plate that a smaller picture lacks; None if it lacks none."""
        is_answering, version = self._desk.live.is_answering, self._facts.plate_version
        is_of_plate = not (is_answering and seen.plate != version)
        is_apart = view.compare is Compare.DIFFERENCE or isinstance(shown, KeptFrame)
        if not view.depth_of_field or not is_of_plate or is_apart:
            return None
        return self._screen.detail(shown, self._desk.renderer.loaded, view)

    def _lights(
        self, shown: Shown, view: ViewState, linear_b: Texture, window: Box
    ) -> tuple[Texture | None, Texture | None]:
        """Return the light of A and of B, each only if it has the size of the plate."""
        whole = window.width, window.height
        light = shown.texture if view.depth_of_field else self._desk.renderer.loaded.color
        is_whole = light.size == whole and not isinstance(shown, KeptFrame)
        return light if is_whole else None, linear_b if linear_b.size == whole else None

    def _lens_of_a(self, view: ViewState, shown: Shown) -> Lens:
        is_look = self._desk.sides.of_a(view) is shown
        look = look_called(self._facts.shot, view.a_look) if is_look else None
        return self._facts.lens if look is None else look.lens

    def _lens_of_b(self, view: ViewState) -> Lens:
        look = look_called(self._facts.shot, view.b_look) if is_look_b(view) else None
        return self._facts.lens if look is None else look.lens

    def _overlay(self, view: ViewState, seen: Shown) -> Texture | None:
        facts = self._facts
        if not view.has_overlay or not facts.has_lens:
            return None
        shot, frame = facts.seen_shot, facts.frame
        loaded = self._desk.renderer.loaded
        return self._screen.overlay(loaded, shot, frame, view, self._kept.uploaded(seen))

    def _frame_ratio(self, plate: Plate) -> float:
        """Return the share of a plate's frame in view; 1 for a scene, which is drawn as framed."""
        if self._facts.has_camera:
            return 1.0
        return plate_ratio(self._facts.lens, room_of(plate))

    def _tiles(self, view: ViewState, a: Texture, width: int) -> tuple[Tile, ...]:
        """Return the pictures of the grid; nothing if the grid is not shown."""
        if view.compare is not Compare.GRID:
            self._screen.keep_tiles(())
            return ()
        names = grid_names(view, self._facts.shot)
        self._screen.keep_tiles(names)
        looks = [look_called(self._facts.shot, name) for name in names]
        return tuple(
            Tile("", f"now   {self._words(self._facts.lens)}", a, a.width != width, False)
            if look is None
            else self._tile(look, view, width)
            for look in looks
        )

    def _tile(self, look: Look, view: ViewState, width: int) -> Tile:
        sides = self._desk.sides
        shown = sides.of_look(look.name)
        words = f"{look.name}   {self._words(look.lens)}"
        is_taken = self._facts.lens == look.lens
        if shown is None:
            words += "   rendering ..."
        elif sides.is_coming(look.name):
            words += "   preview, rendering ..."
        if shown is None:
            return Tile(look.name, printable(words), None, False, is_taken)
        texture = self._screen.tile(look.name, shown, view.exposed_through(look.lens))
        return Tile(look.name, printable(words), texture, texture.width != width, is_taken)

    def _words(self, lens: Lens) -> str:
        distance = measured_text(lens, lens.focus_distance_m, self._facts.view.unit)
        return f"{lens.focal_length_mm:.4g} mm  f/{lens.f_stop:.3g}  at {distance}"
