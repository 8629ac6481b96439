"""The page of a report: the values that the template `page.html.jinja` shows.

The page holds no script and loads nothing but the pictures beside it.
"""

from dataclasses import dataclass
from pathlib import Path

from heatlens.files.html_page import check_pages, page_of
from heatlens.measure.study.measured import Report
from heatlens.measure.study.pictures import REFERENCE, SHARP, crop_name, flip_inside, whole_pictures
from heatlens.model.boxes import Box
from heatlens.plate.plate import FloatImage
from heatlens.version import __version__

_TEMPLATE = Path(__file__).with_name("page.html.jinja")
_PURPOSE = "The page of a study"


@dataclass(frozen=True)
class Crop:
    """One picture at one place; `flip` is None for the reference itself."""

    file: str
    title: str
    flip: float | None


@dataclass(frozen=True)
class Place:
    """A place at which all pictures are shown side by side.

    number   counts from 1
    outline  CSS that puts the frame of the place on the whole picture
    """

    number: int
    box: Box
    outline: str
    crops: tuple[Crop, ...]


def check_page() -> None:
    """Raise InputError if the package that makes the page is not installed."""
    check_pages(_PURPOSE)


def page_html(report: Report, chart: str) -> str:
    """Return the whole page, valid HTML 5 with every name escaped; `chart` is a file beside it.

    Raises InputError if the package that makes the page is not installed.
    """
    values = {**_values(report), "chart": chart}
    return page_of(_PURPOSE, _TEMPLATE, values, {"duration": duration})


def duration(seconds: float) -> str:
    """Return a time with three digits, as 812 ms or 1.24 s."""
    if seconds < 0.9995:
        return f"{1e3 * seconds:.3g} ms"
    return f"{seconds:.3g} s" if seconds < 999.5 else f"{seconds:.0f} s"


def _values(report: Report) -> dict[str, object]:
    """Return everything that the template names, besides the chart."""
    return {
        "report": report,
        "fastest": min(report.rows, key=lambda row: row.seconds),
        "worst_flip": max(row.scores.flip for row in report.rows) or 1.0,
        "runs": max(row.runs for row in report.rows),
        "has_single_runs": any(row.runs == 0 for row in report.rows),
        "word": "truth" if report.reference.is_truth else "reference",
        "reference_title": _reference_title(report),
        "places": [_place(report, number, box) for number, box in enumerate(report.crops, 1)],
        "version": __version__,
    }


def _place(report: Report, number: int, box: Box) -> Place:
    crops = tuple(_crop(report, name, light, number, box) for name, light in whole_pictures(report))
    return Place(number, box, _outline(box, report.size), crops)


def _crop(report: Report, name: str, light: FloatImage, number: int, box: Box) -> Crop:
    title = {REFERENCE: _reference_title(report), SHARP: "before the lens"}.get(name, name)
    flip = None if name == REFERENCE else flip_inside(light, report.reference.pixels, box)
    return Crop(crop_name(name, number), title, flip)


def _outline(box: Box, size: tuple[int, int]) -> str:
    """Return the box as CSS, in percent of a picture of `size` (width, height)."""
    width, height = size
    shares = {
        "left": box.x0 / width,
        "top": box.y0 / height,
        "width": box.width / width,
        "height": box.height / height,
    }
    return ";".join(f"{name}:{100 * share:.3f}%" for name, share in shares.items())


def _reference_title(report: Report) -> str:
    return "truth" if report.reference.is_truth else report.reference.name
