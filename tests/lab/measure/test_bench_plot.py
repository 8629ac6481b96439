"""Test the plot of `heatlens bench --methods`: complete files, and legends for every line."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from PIL import Image as PillowImage

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.bench import plot_panels
from heatlens.lab.measure.bench.method_errors import ErrorCell, ErrorReport, ErrorRow
from heatlens.lab.measure.bench.methods import MethodReport, MethodRow
from heatlens.lab.measure.bench.plot_panels import time_panel, trade_panel, trade_row, write_plot
from heatlens.lab.measure.chart import new_figure

TIMES = MethodReport(
    width=64,
    height=48,
    limit_s=20.0,
    rows=(
        MethodRow(2.0, {"diffusion": 4.0, "gather": 1.0, "accumulation 23": 9.0}),
        MethodRow(20.0, {"diffusion": 4.1, "gather": 100.0, "accumulation 23": 9.0}),
        MethodRow(200.0, {"diffusion": 4.0, "gather": None, "accumulation 23": 9.1}),
    ),
)


def cell(ms: float, flip: float) -> ErrorCell:
    return ErrorCell(ms, flip, psnr_db=30.0, ssim=0.9)


ERRORS = ErrorReport(
    width=32,
    height=24,
    limit_s=20.0,
    truth_views=1024,
    rows=(
        ErrorRow(2.0, 0.001, {"diffusion": cell(4.0, 0.01), "gather": cell(1.0, 0.02)}),
        ErrorRow(20.0, 0.002, {"diffusion": cell(4.0, 0.03), "gather": cell(90.0, 0.0)}),
        ErrorRow(200.0, 0.02, {"diffusion": cell(4.0, 0.07), "gather": None}),
    ),
)


@pytest.mark.parametrize("suffix", ["png", "svg"])
@pytest.mark.parametrize("errors", [None, ERRORS])
def test_write_plot_writes_png_or_svg(tmp_path, suffix, errors):
    path = tmp_path / f"methods.{suffix}"
    write_plot(path, TIMES, errors, "made")
    if suffix == "png":
        with PillowImage.open(path) as image:
            assert image.size == ((1350, 825) if errors is None else (1950, 1350))
    else:
        assert "<svg" in path.read_text("utf-8")
    assert list(tmp_path.iterdir()) == [path]


def legend_of(axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def plotted_figure(tmp_path, monkeypatch, times, errors):
    """Return the figure that `write_plot` wrote."""
    figures: list = []
    original_figure = plot_panels._three_panel_figure
    monkeypatch.setattr(
        plot_panels,
        "_three_panel_figure",
        lambda *a: figures.append(original_figure(*a)) or figures[-1],
    )
    write_plot(tmp_path / "a.png", times, errors, "made")
    return figures[0]


def test_plot_legends_follow_order_of_lines(tmp_path, monkeypatch):
    figure = plotted_figure(tmp_path, monkeypatch, TIMES, ERRORS)
    time, error, trade = figure.axes
    assert all(axes.get_yscale() == axes.get_xscale() == "log" for axes in figure.axes)
    assert legend_of(time) == [
        *("as the disc's area", "gather, over 20 s", "accumulation 23", "diffusion")
    ]
    assert legend_of(error) == ["diffusion", "gather, over 20 s", "noise of the truth"]
    assert legend_of(trade) == ["diffusion", "gather"]


def test_plot_legends_lie_between_panel_and_figure_edge(tmp_path, monkeypatch):
    figure = plotted_figure(tmp_path, monkeypatch, TIMES, ERRORS)
    figure.draw_without_rendering()  # at the resolution that its text is measured with
    for axes in figure.axes:
        legend = axes.get_legend().get_window_extent()
        assert legend.x0 >= axes.get_window_extent().x1 - 1
        assert figure.bbox.x0 <= legend.x0 and legend.x1 <= figure.bbox.x1


def test_trade_panel_uses_20_px_row_and_marks_methods_without_it():
    assert trade_row(ERRORS).coc_px == 20.0
    row_without_gather = ErrorRow(20.0, 0.002, {"diffusion": cell(4.0, 0.03), "gather": None})
    errors = replace(ERRORS, rows=(ERRORS.rows[0], row_without_gather))
    figure = new_figure(6, 4)
    trade_panel(figure.subplots(), errors)
    assert legend_of(figure.axes[0]) == ["diffusion", "gather, at 2 px"]


@pytest.mark.parametrize("measured_names", [(), ("diffusion",)])
def test_plot_omits_methods_without_measurement(tmp_path, monkeypatch, measured_names):
    times = {name: 1.0 if name in measured_names else None for name in ("diffusion", "gather")}
    cells = {name: cell(1.0, 0.1) if name in measured_names else None for name in times}
    rows = (MethodRow(2.0, times), MethodRow(20.0, times))
    errors = replace(ERRORS, rows=(ErrorRow(2.0, 0.0, cells), ErrorRow(20.0, 0.0, cells)))
    figure = plotted_figure(tmp_path, monkeypatch, replace(TIMES, rows=rows), errors)
    names = [name for axes in figure.axes for name in legend_of(axes)]
    assert "gather" not in names
    assert names.count("diffusion") == 3 * len(measured_names)


def test_dotted_line_of_time_panel_grows_with_square_of_blur():
    figure = new_figure(6, 4)
    axes = figure.subplots()
    time_panel(axes, TIMES)
    (line,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    (x0, x1), (y0, y1) = line.get_data()
    assert (x0, x1) == (2.0, 20.0) and y1 / y0 == pytest.approx(100.0)
    assert y1 == pytest.approx(200.0)  # beside gather, which grows most


def test_interrupted_write_plot_keeps_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")

    def interrupted(temporary_path, **_) -> None:
        assert temporary_path.parent == tmp_path and temporary_path != path
        temporary_path.write_bytes(b"half")
        raise KeyboardInterrupt

    figure = SimpleNamespace(savefig=interrupted, suptitle=lambda *_, **__: None)
    monkeypatch.setattr(plot_panels, "_time_figure", lambda _: figure)
    with pytest.raises(KeyboardInterrupt):
        write_plot(path, TIMES, None, "made")
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_write_plot_rejects_missing_folder(tmp_path):
    with pytest.raises(InputError, match="folder"):
        write_plot(tmp_path / "none" / "a.png", TIMES, None, "made")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--plot", "a.png"], "--methods"),
        (["--methods", "--plot", "a.jpg"], ".png or .svg"),
        (["--methods", "--plot", "nowhere/a.png"], "no folder nowhere"),
    ],
)
def test_bench_rejects_impossible_plot_before_measuring(capsys, words, message):
    assert main(["bench", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1


def test_bench_plot_without_matplotlib_names_pip_install(capsys, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["bench", "--methods", "--plot", str(tmp_path / "a.png")]) == 2
    assert "pip install 'heatlens[plot]'" in capsys.readouterr().err
