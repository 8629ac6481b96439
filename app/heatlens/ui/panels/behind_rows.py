"""Draw the list of background pictures of a plate, which show what its foreground hides."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from heatlens.base.printable import printable
from heatlens.plate.plate import BehindReport
from heatlens.ui import probe, theme, widgets

_TIP = (
    "Pictures with depth of the same camera: what the lens uncovers behind a silhouette is then "
    "known instead of guessed."
)


def behind_rows(
    files: Sequence[str],
    reports: Mapping[str, BehindReport],
    problem: str,
    ask: Callable[[], None],
) -> tuple[str, ...]:
    """Draw the list; return the files and patterns as the user left them.

    `reports` say by name what each picture adds, also for parts of the plate's own file.
    `problem` says why `files` cannot be read, or is "". `ask` opens the dialog for another one.
    """
    imgui.separator_text("What lies behind")
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(_TIP)
    for name, report in reports.items():
        if name not in files:
            _sentence(report.sentence)
            probe.note(f"behind {name}")
    kept = tuple(text for text in files if not _row(text, reports.get(text)))
    widgets.colored_text(problem, theme.colors.bad)
    probe.note("behind problem")
    if imgui.button("Add a picture behind...", ImVec2(-1, 0)):
        ask()
    probe.note("Add a picture behind")
    return kept


def _row(text: str, report: BehindReport | None) -> bool:
    """Draw one file with what it adds; return True if the user removes it."""
    is_removed = imgui.small_button(f"x##{text}")
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(printable(f"Take {text} away"))
    probe.note(f"remove {text}")
    imgui.same_line()
    imgui.text_wrapped(printable(Path(text).name))
    if report is not None:
        _sentence(f"It {report.words}.")
        probe.note(f"behind {text}")
    return bool(is_removed)


def _sentence(words: str) -> None:
    widgets.colored_text(words, imgui.get_style_color_vec4(imgui.Col_.text_disabled))
