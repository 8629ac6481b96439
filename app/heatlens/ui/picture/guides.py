"""Draw mattes and guide lines over the picture."""

from imgui_bundle import ImVec2, imgui

from heatlens.model.guides import NO_GUIDES, Guides, guide_shapes, inner_rect
from heatlens.model.view_geometry import PictureShape
from heatlens.session.pictures.picture_view import PictureView
from heatlens.ui import probe, theme


def draw_guides(guides: Guides, shape: PictureShape, place: PictureView) -> None:
    """Draw the guides over the picture at `place`, in the current window."""
    if guides == NO_GUIDES:
        return
    first = place.geometry.window_at_picture((0.0, 0.0))
    last = place.geometry.window_at_picture((shape.width_px, shape.height_px))
    picture = (*first, *last)
    shapes = guide_shapes(guides, picture)
    draw = imgui.get_window_draw_list()
    (x, y), (width, height) = place.viewport.corner, place.viewport.size
    draw.push_clip_rect(ImVec2(x, y), ImVec2(x + width, y + height), True)
    shade = theme.packed((0.0, 0.0, 0.0, guides.opacity))
    for rect in shapes.shades:
        draw.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), shade)
    for rect in shapes.frames:
        draw.add_rect(ImVec2(*rect[:2]), ImVec2(*rect[2:]), theme.OVER_PICTURE.guide)
    for line in shapes.lines:
        draw.add_line(ImVec2(*line[:2]), ImVec2(*line[2:]), theme.OVER_PICTURE.guide)
    draw.pop_clip_rect()
    probe.note_at("matte in the picture", inner_rect(picture, guides.aspect))
