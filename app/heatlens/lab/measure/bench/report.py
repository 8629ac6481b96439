"""The results of the bench as values, which become JSON field by field, and as tables of text."""

from collections.abc import Iterable
from dataclasses import dataclass

from heatlens.lab.measure.bench.drag import DragReport, drag_table
from heatlens.lab.measure.bench.method_errors import ErrorReport
from heatlens.lab.measure.bench.methods import MethodReport

_WIDTH = 14


@dataclass(frozen=True, slots=True)
class PassRow:
    """One pass of a frame; values are None if the bytes depend only on the plate.

    at_least        the bytes, and so the rate, leave out work on listed pixels only
    at_most         the bytes count each layer fully, even where it is not solved or is smaller
    moved_gb_per_s  bytes moved per time; copy_share is the ratio to that of a copy
    """

    name: str
    ms: float
    runs: int
    bytes_moved: int | None
    bytes_least: int | None
    at_least: bool
    moved_gb_per_s: float | None
    copy_share: float | None
    at_most: bool = False


@dataclass(frozen=True, slots=True)
class FrameReport:
    """A frame of the scene; milliseconds are medians over `runs`, until the GPU has finished.

    stopwatch_frame_ms  the same with every pass timed, which keeps the GPU from running ahead
    """

    renderer: str
    is_software: bool
    width: int
    height: int
    proxy: float
    method: str
    bokeh: str
    quality: str
    layer_count: int
    solver: str
    runs: int
    copy_gb_per_s: float
    passes: tuple[PassRow, ...]
    frame_ms: float
    stopwatch_frame_ms: float


@dataclass(frozen=True, slots=True)
class CocRow:
    """Frames by circle of confusion; each ratio is relative to the first row.

    one_layer, layered  the same coc everywhere, without and with layers
    scene               the lens opened until this is the largest coc, which changes the layers
    """

    coc_px: float
    one_layer_ms: float
    one_layer_ratio: float
    layered_ms: float
    layered_ratio: float
    layered_layer_count: int
    scene_ms: float
    scene_ratio: float
    scene_layer_count: int


@dataclass(frozen=True, slots=True)
class SizeRow:
    """Frames of the scene by size; ratios are of the time per pixel, relative to the first row."""

    width: int
    height: int
    one_layer_ms: float
    one_layer_per_pixel_ratio: float
    layered_ms: float
    layered_per_pixel_ratio: float
    layer_count: int


@dataclass(frozen=True, slots=True)
class BareReport:
    """A frame with one layer of heat, and only its two line sweeps."""

    heat_frame_ms: float
    bare_sweeps_ms: float
    ratio: float


@dataclass(frozen=True, slots=True)
class BenchReport:
    """All results; None for measurements that were not requested."""

    frame: FrameReport | None
    coc_sweep: tuple[CocRow, ...] | None
    size_sweep: tuple[SizeRow, ...] | None
    bare: BareReport | None
    peak_memory_mb: float
    methods: MethodReport | None = None
    method_errors: ErrorReport | None = None
    drag: DragReport | None = None


def report_text(report: BenchReport) -> str:
    """Return the report as text: a head, a table of passes, the other measurements, memory."""
    blocks = []
    if report.frame is not None:
        blocks += [_frame_head(report.frame), _pass_table(report.frame), _frame_line(report.frame)]
    if report.coc_sweep is not None:
        blocks.append(_coc_table(report.coc_sweep))
    if report.size_sweep is not None:
        blocks.append(_size_table(report.size_sweep))
    if report.bare is not None:
        blocks.append(_bare_line(report.bare))
    if report.methods is not None:
        blocks.append(time_table(report.methods))
    if report.method_errors is not None:
        blocks.append(error_tables(report.method_errors))
    if report.drag is not None:
        blocks.append(drag_table(report.drag))
    blocks.append(f"peak memory {report.peak_memory_mb:.0f} MB")
    return "\n\n".join(blocks)


def _frame_head(frame: FrameReport) -> str:
    """Return the machine, the size and the settings of a measured frame, in two lines."""
    clock = (
        "a software rasteriser: passes are timed by wall clock around glFinish"
        if frame.is_software
        else "passes are timed by the GPU's timer queries"
    )
    proxy = f" at proxy {frame.proxy:g}" if frame.proxy < 1.0 else ""
    return (
        f"{frame.renderer}; {clock}\n"
        f"{frame.width}x{frame.height}{proxy}, method {frame.method}, "
        f"bokeh {frame.bokeh}, quality {frame.quality}, "
        f"layers {frame.layer_count}, solver {frame.solver}, median of {frame.runs}"
    )


def _pass_table(frame: FrameReport) -> str:
    """Return the passes of a frame as a table: time, runs, bytes moved and their rate."""
    lines = ["pass                 ms   runs    MB moved    MB least      GB/s   of copy"]
    for row in frame.passes:
        mark = "+" if row.at_least else "-" if row.at_most else " "
        cells = (
            _number(row.bytes_moved, 1e-6, 1) + mark,
            _number(row.bytes_least, 1e-6, 1) + mark,
            _number(row.moved_gb_per_s, 1.0, 2, 9) + mark,
            _number(row.copy_share, 100.0, 0, 7) + " %",
        )
        lines.append(f"{row.name:14}{row.ms:9.2f}{row.runs:7d}{''.join(cells)}")
    lines.append(
        "+ listed pixels come on top; - masks and smaller layers save some of it; "
        f"a copy reaches {frame.copy_gb_per_s:.2f} GB/s, more comes from caches"
    )
    return "\n".join(lines)


def _number(value: float | None, scale: float, digits: int, width: int = 11) -> str:
    return f"{'-':>{width}}" if value is None else f"{value * scale:{width}.{digits}f}"


def _frame_line(frame: FrameReport) -> str:
    return (
        f"whole frame {frame.frame_ms:.1f} ms; "
        f"{frame.stopwatch_frame_ms:.1f} ms with the stopwatch on"
    )


def _coc_table(rows: tuple[CocRow, ...]) -> str:
    """Return the times by circle of confusion as a table."""
    lines = [
        "circle of confusion   one layer        layered                  scene, this its largest",
        "                px       ms  ratio         ms  ratio  layers         ms  ratio  layers",
    ]
    lines += [
        f"{row.coc_px:18g}{row.one_layer_ms:9.1f}{row.one_layer_ratio:7.2f}"
        f"{row.layered_ms:11.1f}{row.layered_ratio:7.2f}{row.layered_layer_count:8d}"
        f"{row.scene_ms:11.1f}{row.scene_ratio:7.2f}{row.scene_layer_count:8d}"
        for row in rows
    ]
    return "\n".join(lines)


def _size_table(rows: tuple[SizeRow, ...]) -> str:
    """Return the times by picture size as a table."""
    lines = [
        "size              one layer             layered",
        "                       ms  ratio/px          ms  ratio/px  layers",
    ]
    lines += [
        f"{f'{row.width}x{row.height}':16}{row.one_layer_ms:9.1f}"
        f"{row.one_layer_per_pixel_ratio:10.2f}{row.layered_ms:12.1f}"
        f"{row.layered_per_pixel_ratio:10.2f}{row.layer_count:8d}"
        for row in rows
    ]
    return "\n".join(lines)


def _bare_line(bare: BareReport) -> str:
    return (
        f"heat, one layer: frame {bare.heat_frame_ms:.1f} ms, two bare Thomas sweeps "
        f"{bare.bare_sweeps_ms:.1f} ms, ratio {bare.ratio:.2f}"
    )


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
        "a scene, by its largest circle of confusion;\ntruth: the error of half its views"
    )
    return "\n\n".join(
        [
            head + "\n" + _error_table(report, "FLIP, 0 is equal", "flip", 4, with_truth=True),
            _error_table(report, "PSNR [dB], higher is closer", "psnr_db", 1),
            _error_table(report, "SSIM, 1 is equal", "ssim", 4),
            _error_table(report, "ms a frame of that scene; plates are given", "ms", 1),
        ]
    )


def _error_table(
    report: ErrorReport, title: str, field: str, digits: int, with_truth: bool = False
) -> str:
    """Return the table of one field of `ErrorCell`, with that of the truth if `with_truth`."""
    rows = []
    for row in report.rows:
        cells = {
            name: None if cell is None else getattr(cell, field) for name, cell in row.cells.items()
        }
        rows.append((row.coc_px, cells | ({"truth": row.truth_flip} if with_truth else {})))
    return "\n".join([title, *_table(list(rows[0][1]), rows, digits)])


def _table(
    names: list[str], rows: Iterable[tuple[float, dict[str, float | None]]], digits: int
) -> list[str]:
    """Return aligned lines; the number of views is below the name of its method."""
    names_and_views = [name.partition(" ") for name in names]
    lines = [
        "    px" + "".join(f"{name:>{_WIDTH}}" for name, _, _ in names_and_views),
        "      "
        + "".join(
            f"{f'{views} views' if views else '':>{_WIDTH}}" for _, _, views in names_and_views
        ),
    ]
    for coc, cells in rows:
        lines.append(f"{coc:6g}" + "".join(_cell(cells[name], digits) for name in names))
    return lines


def _cell(value: float | None, digits: int) -> str:
    return f"{'skipped':>{_WIDTH}}" if value is None else f"{value:{_WIDTH}.{digits}f}"
