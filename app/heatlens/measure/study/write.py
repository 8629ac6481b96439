"""A report into its folder: pictures, page and numbers."""

from collections.abc import Callable
from pathlib import Path

from heatlens.measure.study.folder import write_numbers
from heatlens.measure.study.numbers import report_numbers
from heatlens.measure.study.pictures import write_pictures
from heatlens.measure.study.report import Report
from heatlens.measure.study.report_html import report_html

PAGE = "index.html"


def write_report(folder: Path, report: Report, say: Callable[[str], None]) -> None:
    """Everything, into an empty folder. Raises InputError where a picture cannot be written."""
    say("writing the pictures")
    files = list(write_pictures(folder, report))
    (folder / PAGE).write_text(report_html(report), encoding="utf-8")
    write_numbers(folder, report_numbers(report), [*files, PAGE])
