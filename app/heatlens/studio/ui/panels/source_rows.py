"""Draw the rows of a plate's background pictures, and those of its mattes.

Background pictures show what the foreground of a plate hides. Mattes name objects of the plate; a
click on an object can choose its matte.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.option import Values, options_of
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.plate import BehindReport
from heatlens.studio.ui import rects, texts, theme, widgets

_TIP = (
    "Pictures with depth from the same camera. They show what the lens sees behind silhouettes, "
    "which is guessed otherwise."
)


def behind_rows(
    files: Sequence[str],
    reports: Mapping[str, BehindReport],
    problem: str,
    ask_behind: Callable[[], None],
) -> tuple[str, ...]:
    """Draw the list; return the files and patterns as the user left them.

    `reports` describe by name what each picture adds, also for parts of the plate's own file.
    `problem` is the reason why `files` cannot be read, or "". `ask_behind` opens the dialog for
    another picture.
    """
    imgui.separator_text("What lies behind")
    texts.tooltip(_TIP)
    for name, report in reports.items():
        if name not in files:
            texts.gray_text(report.sentence)
            rects.note(f"behind {name}")
    kept_files = tuple(text for text in files if not _behind_row(text, reports.get(text)))
    texts.colored_text(problem, theme.colors.bad)
    rects.note("behind problem")
    if widgets.button("Add clean plate...", "Add clean plate", width=-1):
        ask_behind()
    return kept_files


def _behind_row(text: str, report: BehindReport | None) -> bool:
    """Draw one file and a sentence about what it adds; return True if the user removes it."""
    is_removed = widgets.small_button(f"x##{text}", f"remove {text}", f"Remove {text}")
    imgui.same_line()
    imgui.text_wrapped(printable(Path(text).name))
    if report is not None:
        texts.gray_text(f"It {report.words}.")
        rects.note(f"behind {text}")
    return is_removed


_PICK_TIP = "Ctrl+Shift+click then tells the thing, if the plate has Cryptomatte or ids."
_TIPS = {
    "flat_depth": "Mends a wrong depth inside a matte, such as cryptomatte:card or "
    "plane:matte:mask.A.",
    "never_blur": "Stays sharp at any focus: a title, the insert of a screen.",
    "only_blur": "All but this stays sharp.",
}


def matte_rows(
    options: PlateOptions, notify: Callable[[str], None], pick_matte: Callable[[str], None]
) -> PlateOptions:
    """Draw the fold of what a matte keeps sharp or blurs; return the options as the user left them.

    `pick_matte` is called with the name of the field whose matte the next click chooses.
    """
    words_by_field = {field: options_of(PlateOptions)[field].words for field in _TIPS}
    if not widgets.folded_header("Mattes for the blur", tuple(words_by_field.values())):
        return options
    style = imgui.get_style()
    button_px = imgui.calc_text_size("pick").x + 2 * style.frame_padding.x + style.item_spacing.x
    for field, tip in _TIPS.items():
        words, text = words_by_field[field], getattr(options, field)
        widgets.label(words, tip)
        imgui.set_next_item_width(-button_px)
        typed_matte = widgets.text_field(
            words, text or "", text, widgets.optional(str.strip), notify
        )
        imgui.same_line()
        if widgets.button(f"pick##{words}", f"pick {words}", _PICK_TIP):
            pick_matte(field)
        changes: Values = {field: typed_matte}
        options = replace(options, **changes)
    return options
