"""Write a report into its folder completely or not at all, and never replace other files.

The page of a report shows the values in the template `page.html.jinja`. It holds no script and
loads nothing but the pictures beside it.
"""

import json
import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file
from heatlens.core.base.stopping import mark_unfinished
from heatlens.core.model.boxes import Box
from heatlens.lab.measure.chart import write_figure
from heatlens.lab.measure.study.measured import Report, Row
from heatlens.lab.measure.study.pictures import (
    REFERENCE,
    SHARP,
    crop_name,
    error_chart,
    flip_inside,
    whole_pictures,
    write_pictures,
)
from heatlens.media.files.html_page import render_page
from heatlens.media.plate.plate import FloatImage
from heatlens.version import __version__

_TEMPLATE = Path(__file__).with_name("page.html.jinja")


@dataclass(frozen=True)
class Crop:
    """One picture at one place; `flip` is None for the reference itself."""

    file: str
    title: str
    flip: float | None


@dataclass(frozen=True)
class ComparedArea:
    """A place at which all pictures are shown side by side.

    number   counts from 1
    outline  CSS that puts the frame of the place on the whole picture
    """

    number: int
    box: Box
    outline: str
    crops: tuple[Crop, ...]


def page_html(report: Report, chart: str) -> str:
    """Return the whole page, valid HTML 5 with every name escaped; `chart` is a file beside it."""
    values = {**_values(report), "chart": chart}
    return render_page(_TEMPLATE, values, {"duration": duration})


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
        "places": [
            _place_of_crop(report, number, box) for number, box in enumerate(report.crops, 1)
        ],
        "version": __version__,
    }


def _place_of_crop(report: Report, number: int, box: Box) -> ComparedArea:
    """Return the crops of all pictures at the box of this number."""
    crops = tuple(_crop(report, name, light, number, box) for name, light in whole_pictures(report))
    return ComparedArea(number, box, _outline(box, report.size), crops)


def _crop(report: Report, name: str, light: FloatImage, number: int, box: Box) -> Crop:
    """Return the crop of the picture `name`, with its mean FLIP from the reference."""
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


NUMBERS = "study.json"  # lists every file of the report, which identifies the folder
_MARK = "heatlens_study"
VERSION = 1
_REPORT_FILE = re.compile(r"[a-z0-9-]+\.(html|png|svg|json)")  # possible names of its files
_RECORD_MOST_BYTES = 1 << 20
PAGE, CHART = "index.html", "chart.svg"


@contextmanager
def report_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a folder to write into; it replaces `path` when the block ends without an error.

    An older report stays there until then, and after an error. A link keeps its target. Raises
    InputError if `path` holds anything else, or if nothing can be written there.
    """
    target = check_target(path)
    temporary_folder = target.with_name(f".heatlens-{secrets.token_hex(8)}.part")
    try:
        with mark_unfinished(temporary_folder):
            temporary_folder.mkdir()
            yield temporary_folder
            _replace_folder(temporary_folder, target)
    except OSError as error:
        raise InputError(f"{target} could not be written: {error}") from error
    finally:
        shutil.rmtree(temporary_folder, ignore_errors=True)


def check_target(path: str | os.PathLike[str]) -> Path:
    """Return the path of the folder; raise InputError where it may not be written or replaced."""
    target = Path(os.path.realpath(path))
    if not target.parent.is_dir():
        raise InputError(f"{path}: there is no folder {target.parent} to write the report in.")
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"{path}: {target.parent} is not writable.")
    if target.exists() and not target.is_dir():
        raise InputError(f"{path} is a file: give the name of a folder for the report.")
    if target.is_dir():
        _check_is_ours(target)
    return target


def write_numbers(folder: Path, numbers: dict[str, object], files: list[str]) -> None:
    """Write the record of the report: its numbers and the names of all its files."""
    record = {_MARK: VERSION, **numbers, "files": sorted([*files, NUMBERS])}
    text = json.dumps(record, indent=2, allow_nan=False)
    (folder / NUMBERS).write_text(text + "\n", encoding="utf-8")


def _check_is_ours(folder: Path) -> None:
    """Raise InputError unless the folder holds only the files that its record lists."""
    try:
        names = set(os.listdir(folder))
    except OSError as error:
        raise InputError(f"{folder} cannot be read: {error.strerror}.") from error
    report_files = {name for name in _files_of(folder) if _is_plain_file(folder / name)}
    other_files = sorted(names - report_files)
    if other_files:
        raise InputError(
            f"{folder} holds files that are not a heatlens report ({', '.join(other_files[:3])}"
            f"{', ...' if len(other_files) > 3 else ''}); give another folder or empty this one."
        )


def _files_of(folder: Path) -> set[str]:
    """Return the names in the record of a report; none if there is no such record.

    Names that no report gives to a file are ignored, because the folder may belong to anyone and
    the named files will be deleted.
    """
    try:
        with open_regular_file(folder / NUMBERS) as file:
            record = json.loads(file.read(_RECORD_MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return set()
    if not isinstance(record, dict) or record.get(_MARK) != VERSION:
        return set()
    files = record.get("files")
    names = files if isinstance(files, list) else []
    return {name for name in names if isinstance(name, str) and _REPORT_FILE.fullmatch(name)}


def _is_plain_file(path: Path) -> bool:
    """Return whether a report may have written it: neither a folder nor a link."""
    return path.is_file() and not path.is_symlink()


def _replace_folder(new_folder: Path, target: Path) -> None:
    """Replace the old folder by the new one; put the old one back if that fails."""
    if not target.exists():
        os.rename(new_folder, target)
        return
    _check_is_ours(target)  # checked again, because minutes have passed
    old_folder = new_folder.with_suffix(".old")
    try:
        os.rename(target, old_folder)
        os.rename(new_folder, target)
    finally:
        if old_folder.exists() and not target.exists():
            os.rename(old_folder, target)
    shutil.rmtree(old_folder, ignore_errors=True)


def write_report(folder: Path, report: Report, report_progress: Callable[[str], None]) -> None:
    """Write every file of the report into an empty folder.

    Raises InputError if a file cannot be written.
    """
    report_progress("writing the pictures")
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
    """Return the results of a method as JSON entries."""
    return {
        "method": str(row.method),
        "detail": row.detail,
        "seconds": row.seconds,
        "runs": row.runs,
        **asdict(row.scores),
    }
