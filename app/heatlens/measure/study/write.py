"""Write a report into its folder: pictures, chart, page and numbers."""

from collections.abc import Callable
from pathlib import Path

from heatlens.measure.chart import write_figure
from heatlens.measure.study.error_chart import error_chart
from heatlens.measure.study.folder import write_numbers
from heatlens.measure.study.numbers import report_numbers
from heatlens.measure.study.page import page_html
from heatlens.measure.study.pictures import write_pictures
from heatlens.measure.study.report import Report

PAGE, CHART = "index.html", "chart.svg"


def write_report(folder: Path, report: Report, say: Callable[[str], None]) -> None:
    """Write every file of the report into an empty folder.

    Raises InputError if a file cannot be written.
    """
    say("writing the pictures")
    files = list(write_pictures(folder, report))
    write_figure(folder / CHART, error_chart(report.rows, report.best))
    (folder / PAGE).write_text(page_html(report, CHART), encoding="utf-8")
    write_numbers(folder, report_numbers(report), [*files, CHART, PAGE])
