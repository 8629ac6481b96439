"""The looks: a still of each, the way back to it, and the wipe against it."""

import moderngl
from imgui_bundle import ImVec2, imgui

from heatlens.model.look import Look
from heatlens.model.units import format_distance
from heatlens.model.view import Against, Compare
from heatlens.printable import printable
from heatlens.session.session import Session
from heatlens.ui import probe, theme, widgets
from heatlens.ui.picture.picture_alone import PictureAlone
from heatlens.ui.picture.viewport import Pictures

_STILL_PX = 256, 144
_STILL_EM = 9.6, 5.4
_NAME_EM = 4.0
_STILLS_MOST = 64


class LookStills:
    """Small pictures of looks: taken when the look is seen whole, kept as long as the window."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._alone = PictureAlone(ctx)
        self._taken: dict[tuple[object, Look], moderngl.Texture] = {}

    def of(self, session: Session, look: Look) -> moderngl.Texture | None:
        """Return the still of a look; None before it was seen."""
        return self._taken.get((session.shot.source, look))

    def take(self, session: Session, pictures: Pictures | None) -> None:
        """Keep what is seen, where it is a look that has no still yet; call this once a frame."""
        seen = session.live.shown
        if pictures is None or seen is None or not (seen.is_whole and session.is_plain):
            return
        for look in session.shot.looks:
            is_it = (look.lens, look.frame) == (session.lens, session.frame)
            is_seen = seen.frame == look.frame and seen.shot == session.editing.seen_shot
            if is_it and is_seen and self.of(session, look) is None:
                self._keep((session.shot.source, look), session, pictures)

    def _keep(self, key: tuple[object, Look], session: Session, pictures: Pictures) -> None:
        self._alone.draw(pictures, session.view, _STILL_PX)
        texture = self._alone.hand_over()
        if len(self._taken) >= _STILLS_MOST:
            self._taken.pop(next(iter(self._taken))).release()
        self._taken[key] = texture


def looks_panel(session: Session, stills: LookStills) -> None:
    """Draw it in the current window."""
    if imgui.button("Keep this look"):
        session.looks.keep()
    probe.note("keep look")
    _tip("Keeps length, stop, focus and film back under a letter (Shift+L).")
    is_compared = session.view.against is Against.LOOK and session.view.compare is not Compare.OFF
    imgui.same_line()
    with widgets.disabled(not is_compared):
        if imgui.button("Wipe off"):
            session.view_commands.change(compare=Compare.OFF)
        probe.note("look wipe off")
    if not session.shot.looks:
        imgui.text_wrapped("No looks yet. Set up the lens, then Shift+L keeps it as look A.")
    for index, look in enumerate(session.shot.looks):
        _row(session, stills, index, look)


def _row(session: Session, stills: LookStills, index: int, look: Look) -> None:
    em = imgui.get_font_size()
    imgui.push_id(look.name)
    imgui.separator()
    corner = imgui.get_cursor_screen_pos()
    if _still(stills.of(session, look)):
        session.looks.go(index)
    probe.note(f"look {look.name}")
    _tip(f"Take this lens again (Ctrl+{index + 1})" if index < 9 else "Take this lens again")
    if session.lens == look.lens:
        size = imgui.get_item_rect_size()
        end = ImVec2(corner.x + size.x, corner.y + size.y)
        imgui.get_window_draw_list().add_rect(corner, end, theme.ACCENT, 2.0, 2.0)
    imgui.same_line()
    imgui.begin_group()
    imgui.set_next_item_width(_NAME_EM * em)
    name = widgets.text_field(
        f"look name {look.name}", look.name, look.name, str.strip, session.say
    )
    imgui.same_line()
    lens = look.lens
    imgui.text_disabled(printable(f"{lens.focal_length_mm:.4g} mm  f/{lens.f_stop:.3g}"))
    imgui.text_disabled(f"at {format_distance(lens.focus_distance_m, session.view.unit)}")
    _buttons(session, look)
    imgui.end_group()
    imgui.pop_id()
    if name != look.name:
        session.looks.rename(look, name)


def _buttons(session: Session, look: Look) -> None:
    if imgui.button("wipe"):
        session.looks.compare(look)
    probe.note(f"wipe {look.name}")
    _tip("The frame through this look at the right of the wipe")
    imgui.same_line(0.0, 4.0)
    if imgui.button("x"):
        session.looks.delete(look)
    probe.note(f"delete look {look.name}")


def _still(texture: moderngl.Texture | None) -> bool:
    """Draw the still as a button, or an empty place where there is none."""
    em = imgui.get_font_size()
    size = ImVec2(_STILL_EM[0] * em, _STILL_EM[1] * em)
    corner = imgui.get_cursor_screen_pos()
    pressed = imgui.invisible_button("still", size)
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw = imgui.get_window_draw_list()
    if texture is None:
        draw.add_rect_filled(corner, end, theme.GROOVE, 2.0)
        text = "not seen yet"
        wide = imgui.calc_text_size(text)
        at = ImVec2(corner.x + (size.x - wide.x) / 2, corner.y + (size.y - wide.y) / 2)
        draw.add_text(at, theme.TEXT_DIM, text)
    else:
        draw.add_image(imgui.ImTextureRef(texture.glo), corner, end, ImVec2(0, 1), ImVec2(1, 0))
    return bool(pressed)


def _tip(text: str) -> None:
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(text)
