"""Write a report into its folder: pictures, chart, page and numbers."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from heatlens.measure.chart import write_figure
from heatlens.measure.study.error_chart import error_chart
from heatlens.measure.study.folder import write_numbers
from heatlens.measure.study.measured import Row
from heatlens.measure.study.page import page_html
from heatlens.measure.study.pictures import write_pictures
from heatlens.measure.study.report import Report
from heatlens.version import __version__

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


def report_numbers(report: Report) -> dict[str, object]:
    """Return the numbers as JSON values: seconds, and scores by the names of `Scores`."""
    return {
        "heatlens": __version__,
        "title": report.title,
        "facts": dict(report.facts),
        "reference": report.reference.name,
        "reference_is_truth": report.reference.is_truth,
        "renderer": report.machine,
        "size": list(report.size),
        "crops": [[box.x0, box.y0, box.width, box.height] for box in report.crops],
        "methods": [_row(row) for row in report.rows],
        "left_out": list(report.left_out),
    }


def _row(row: Row) -> dict[str, object]:
    return {
        "method": str(row.method),
        "detail": row.detail,
        "seconds": row.seconds,
        "runs": row.runs,
        **asdict(row.scores),
    }
