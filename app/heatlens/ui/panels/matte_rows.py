"""Draw the rows of the Plate panel that name a thing by its matte, which a click can tell."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from heatlens.model.option import Values, options_of
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.ui import widgets

_PICK_TIP = "Ctrl+Shift+click then tells the thing, if the plate has Cryptomatte or ids."
_TIPS = {
    "flat_depth": "Mends a wrong depth inside a matte, such as cryptomatte:card or "
    "plane:matte:mask.A.",
    "never_blur": "Stays sharp at any focus: a title, the insert of a screen.",
    "only_blur": "All but this stays sharp.",
}


def matte_rows(
    options: PlateOptions, say: Callable[[str], None], pick: Callable[[str], None]
) -> PlateOptions:
    """Draw the rows; return the options as the user left them.

    `pick` is called with the name of a field that the next click shall tell.
    """
    imgui.separator_text("Things, by their mattes")
    style = imgui.get_style()
    beside_px = imgui.calc_text_size("pick").x + 2 * style.frame_padding.x + style.item_spacing.x
    for field, tip in _TIPS.items():
        words, text = options_of(PlateOptions)[field].words, getattr(options, field)
        widgets.label(words, tip)
        imgui.set_next_item_width(-beside_px)
        typed = widgets.text_field(words, text or "", text, widgets.optional(str.strip), say)
        imgui.same_line()
        if widgets.button(f"pick##{words}", f"pick {words}", _PICK_TIP):
            pick(field)
        changed: Values = {field: typed}
        options = replace(options, **changed)
    return options
