"""Collect the textures that the viewport shows: A, B, overlay and grid, with view transform."""

from dataclasses import replace

import moderngl

from heatlens.base.printable import printable
from heatlens.display.screen_pictures import MIPMAPS_UNDER, ScreenPictures, picture_of_b
from heatlens.model.breathing import plate_ratio
from heatlens.model.lens import Lens
from heatlens.model.look import Look
from heatlens.model.measured_distance import measured_text
from heatlens.model.view import Compare, ViewState
from heatlens.plate.breathing_window import room_of
from heatlens.plate.plate import Plate
from heatlens.preview.shown import Shown
from heatlens.session.pictures.compare_sides import grid_names, is_look_b, look_called
from heatlens.session.playing.kept_screen import KeptFrame, KeptScreen
from heatlens.session.session import Session
from heatlens.ui.picture.grid import Tile
from heatlens.ui.picture.pictures import Pictures


class SeenPictures:
    """Prepares the pictures for each frame of the window; unchanged ones are reused."""

    def __init__(self, session: Session, screen: ScreenPictures, kept: KeptScreen) -> None:
        self._session = session
        self._screen = screen
        self._kept = kept

    def now(self) -> Pictures | None:
        """Return the pictures to show; None while there are none."""
        session, plate = self._session, self._session.source.plate
        seen = session.facts.seen
        if plate is None or seen is None:
            return None
        screen, loaded, sides = (
            self._screen,
            session.pictures.renderer.loaded,
            session.pictures.sides,
        )
        is_held_off = session.pictures.view.is_lens_held_off
        plain = session.facts.view
        plain = replace(plain, depth_of_field=plain.depth_of_field and not is_held_off)
        screen.with_mipmaps = session.pictures.view.zoom < MIPMAPS_UNDER
        shown = sides.of_a(plain) or seen
        view = plain.exposed_through(self._lens_of_a(plain, shown))
        reference = session.facts.reference.texture if session.facts.reference else None
        of_method = sides.of_method(view)
        linear_b = picture_of_b(view, loaded, reference, of_method)
        if is_kept := isinstance(shown, KeptFrame):
            a = self._kept.texture(shown, view)
        else:
            a = screen.a(shown, (sides.pictures, shown), loaded, view, linear_b)
        b = a
        if view.compare in (Compare.WIPE, Compare.FLIP):
            view_of_b = plain.exposed_through(self._lens_of_b(plain))
            b = screen.b(linear_b, loaded, view_of_b, of_method)
        detail = None
        version = session.source.picture.version
        is_of_plate = not (session.pictures.live.is_answering and seen.plate != version)
        is_apart = view.compare is Compare.DIFFERENCE or is_kept
        if view.depth_of_field and is_of_plate and not is_apart:
            detail = screen.detail(shown, loaded, view)
        windows = self._kept.windows(seen) or session.source.feed.windows(session.facts.shot)
        light = shown.texture if view.depth_of_field else loaded.color
        whole = windows[0].width, windows[0].height
        return Pictures(
            a,
            b,
            detail,
            self._overlay(view, seen),
            *windows,
            plate.pixel_aspect_ratio,
            is_proxy=a.size != (windows[0].width, windows[0].height),
            is_b_proxy=of_method is not None and b.size != loaded.color.size,
            has_camera=session.facts.has_camera,
            frame_ratio=self._frame_ratio(plate),
            is_a_frame=not view.depth_of_field and not is_kept,
            is_b_frame=linear_b is loaded.color,
            light_a=light if light.size == whole and not is_kept else None,
            light_b=linear_b if linear_b.size == whole else None,
            light_version=(sides.pictures, version),
            has_mipmaps=screen.with_mipmaps,
            tiles=self._tiles(plain, a, windows[0].width),
            names=(plain.a_look or "now", plain.b_look) if is_look_b(plain) else ("A", "B"),
        )

    def _lens_of_a(self, view: ViewState, shown: Shown) -> Lens:
        is_look = self._session.pictures.sides.of_a(view) is shown
        look = look_called(self._session.facts.shot, view.a_look) if is_look else None
        return self._session.facts.lens if look is None else look.lens

    def _lens_of_b(self, view: ViewState) -> Lens:
        look = look_called(self._session.facts.shot, view.b_look) if is_look_b(view) else None
        return self._session.facts.lens if look is None else look.lens

    def _overlay(self, view: ViewState, seen: Shown) -> moderngl.Texture | None:
        session = self._session
        if not view.has_overlay or not session.editing.has_lens:
            return None
        shot, frame = session.editing.seen_shot, session.editing.frame
        loaded = session.pictures.renderer.loaded
        return self._screen.overlay(loaded, shot, frame, view, self._kept.uploaded(seen))

    def _frame_ratio(self, plate: Plate) -> float:
        """Return the share of a plate's frame in view; 1 for a scene, which is drawn as framed."""
        if self._session.facts.has_camera:
            return 1.0
        return plate_ratio(self._session.facts.lens, room_of(plate))

    def _tiles(self, view: ViewState, a: moderngl.Texture, width: int) -> tuple[Tile, ...]:
        """Return the pictures of the grid; nothing if the grid is not shown."""
        if view.compare is not Compare.GRID:
            self._screen.keep_tiles(())
            return ()
        names = grid_names(view, self._session.facts.shot)
        self._screen.keep_tiles(names)
        looks = [look_called(self._session.facts.shot, name) for name in names]
        return tuple(
            Tile("", f"now   {self._words(self._session.facts.lens)}", a, a.width != width, False)
            if look is None
            else self._tile(look, view, width)
            for look in looks
        )

    def _tile(self, look: Look, view: ViewState, width: int) -> Tile:
        session = self._session
        shown = session.pictures.sides.of_look(look.name)
        words = f"{look.name}   {self._words(look.lens)}"
        is_taken = session.facts.lens == look.lens
        if shown is None:
            words += "   rendering ..."
        elif session.pictures.sides.is_coming(look.name):
            words += "   preview, rendering ..."
        if shown is None:
            return Tile(look.name, printable(words), None, False, is_taken)
        texture = self._screen.tile(look.name, shown, view.exposed_through(look.lens))
        return Tile(look.name, printable(words), texture, texture.width != width, is_taken)

    def _words(self, lens: Lens) -> str:
        distance = measured_text(lens, lens.focus_distance_m, self._session.facts.view.unit)
        return f"{lens.focal_length_mm:.4g} mm  f/{lens.f_stop:.3g}  at {distance}"
