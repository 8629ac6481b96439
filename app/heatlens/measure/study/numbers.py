"""The numbers of a report for other programs."""

from dataclasses import asdict
from typing import Any

from heatlens.measure.study.measured import Row
from heatlens.measure.study.report import Report
from heatlens.version import __version__


def report_numbers(report: Report) -> dict[str, Any]:
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


def _row(row: Row) -> dict[str, Any]:
    return {
        "method": str(row.method),
        "detail": row.detail,
        "seconds": row.seconds,
        "runs": row.runs,
        **asdict(row.scores),
    }
