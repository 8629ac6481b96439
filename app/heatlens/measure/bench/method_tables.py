"""Format the times and errors of the methods as text tables."""

from collections.abc import Iterable

from heatlens.measure.bench.method_errors import ErrorReport
from heatlens.measure.bench.methods import MethodReport

_WIDTH = 14


def time_table(report: MethodReport) -> str:
    """Return a table with a row for each circle of confusion and a column for each method."""
    head = (
        f"methods at {report.width}x{report.height}, ms a frame, the same circle of confusion "
        f"everywhere; skipped: more than {report.limit_s:g} s"
    )
    rows = ((row.coc_px, row.ms) for row in report.rows)
    return "\n".join([head, *_table(list(report.rows[0].ms), rows, 1)])


def error_tables(report: ErrorReport) -> str:
    """Return tables of FLIP (with that of the truth itself), PSNR, SSIM and milliseconds."""
    head = (
        f"errors at {report.width}x{report.height}, to the truth of {report.truth_views} views of "
        "a scene, by its largest circle of confusion;\ntruth: how far that of half its views is"
    )
    return "\n\n".join(
        [
            head + "\n" + _of(report, "FLIP, 0 is equal", "flip", 4, with_truth=True),
            _of(report, "PSNR [dB], more is nearer", "psnr_db", 1),
            _of(report, "SSIM, 1 is equal", "ssim", 4),
            _of(report, "ms a frame of that scene; plates are given", "ms", 1),
        ]
    )


def _of(report: ErrorReport, title: str, field: str, digits: int, with_truth: bool = False) -> str:
    rows = []
    for row in report.rows:
        cells = {n: None if c is None else getattr(c, field) for n, c in row.cells.items()}
        rows.append((row.coc_px, cells | ({"truth": row.truth_flip} if with_truth else {})))
    return "\n".join([title, *_table(list(rows[0][1]), rows, digits)])


def _table(
    names: list[str], rows: Iterable[tuple[float, dict[str, float | None]]], digits: int
) -> list[str]:
    """Return aligned lines; the number of views is below the name of its method."""
    words = [name.partition(" ") for name in names]
    lines = [
        "    px" + "".join(f"{word:>{_WIDTH}}" for word, _, _ in words),
        "      " + "".join(f"{f'{n} views' if n else '':>{_WIDTH}}" for _, _, n in words),
    ]
    for coc, cells in rows:
        lines.append(f"{coc:6g}" + "".join(_cell(cells[name], digits) for name in names))
    return lines


def _cell(value: float | None, digits: int) -> str:
    return f"{'skipped':>{_WIDTH}}" if value is None else f"{value:{_WIDTH}.{digits}f}"
