"""Draw the list of background pictures of a plate, which show what its foreground hides."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from imgui_bundle import imgui

from heatlens.base.printable import printable
from heatlens.plate.plate import BehindReport
from heatlens.ui import probe, theme, widgets

_TIP = (
    "Pictures with depth from the same camera. They show what the lens sees behind silhouettes, "
    "which is guessed otherwise."
)


def behind_rows(
    files: Sequence[str], reports: Mapping[str, BehindReport], problem: str, ask: Callable[[], None]
) -> tuple[str, ...]:
    """Draw the list; return the files and patterns as the user left them.

    `reports` say by name what each picture adds, also for parts of the plate's own file.
    `problem` says why `files` cannot be read, or is "". `ask` opens the dialog for another one.
    """
    imgui.separator_text("What lies behind")
    widgets.tooltip(_TIP)
    for name, report in reports.items():
        if name not in files:
            widgets.grey_text(report.sentence)
            probe.note(f"behind {name}")
    kept = tuple(text for text in files if not _row(text, reports.get(text)))
    widgets.colored_text(problem, theme.colors.bad)
    probe.note("behind problem")
    if widgets.button("Add a picture behind...", "Add a picture behind", width=-1):
        ask()
    return kept


def _row(text: str, report: BehindReport | None) -> bool:
    """Draw one file with what it adds; return True if the user removes it."""
    is_removed = widgets.small_button(f"x##{text}", f"remove {text}", f"Remove {text}")
    imgui.same_line()
    imgui.text_wrapped(printable(Path(text).name))
    if report is not None:
        widgets.grey_text(f"It {report.words}.")
        probe.note(f"behind {text}")
    return is_removed
