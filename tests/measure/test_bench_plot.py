"""The plot of `heatlens bench --methods`: whole or not there, and its names clear of each other."""

import sys
from dataclasses import replace
from itertools import combinations, pairwise
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as PillowImage

from heatlens.commands.main import main
from heatlens.errors import InputError
from heatlens.measure.bench import methods, plot
from heatlens.measure.bench.method_errors import ErrorCell, ErrorReport, ErrorRow
from heatlens.measure.bench.methods import MethodReport, MethodRow
from heatlens.measure.bench.plot import write_plot
from heatlens.measure.bench.plot_labels import Label, name_lines, name_points, spread
from heatlens.measure.bench.plot_panels import chosen_row, time_panel, trade_panel

TIMES = MethodReport(
    64,
    48,
    20.0,
    (
        MethodRow(2.0, {"diffusion": 4.0, "gather": 1.0, "accumulation 23": 9.0}),
        MethodRow(20.0, {"diffusion": 4.1, "gather": 100.0, "accumulation 23": 9.0}),
        MethodRow(200.0, {"diffusion": 4.0, "gather": None, "accumulation 23": 9.1}),
    ),
)


def cell(ms: float, flip: float) -> ErrorCell:
    return ErrorCell(ms, flip, 30.0, 0.9)


ERRORS = ErrorReport(
    32,
    24,
    20.0,
    1024,
    (
        ErrorRow(2.0, 0.001, {"diffusion": cell(4.0, 0.01), "gather": cell(1.0, 0.02)}),
        ErrorRow(20.0, 0.002, {"diffusion": cell(4.0, 0.03), "gather": cell(90.0, 0.0)}),
        ErrorRow(200.0, 0.02, {"diffusion": cell(4.0, 0.07), "gather": None}),
    ),
)


@pytest.mark.parametrize("suffix", ["png", "svg"])
@pytest.mark.parametrize("errors", [None, ERRORS])
def test_a_plot_is_a_picture_of_that_kind(tmp_path, suffix, errors):
    path = tmp_path / f"methods.{suffix}"
    write_plot(path, TIMES, errors, "made")
    if suffix == "png":
        with PillowImage.open(path) as image:
            assert image.size == ((1350, 825) if errors is None else (1950, 1350))
    else:
        assert "<svg" in path.read_text("utf-8")
    assert list(tmp_path.iterdir()) == [path]


def texts_of(figure) -> list[str]:
    return [text.get_text().strip() for axes in figure.axes for text in axes.texts]


def test_lines_and_points_carry_their_names(tmp_path, monkeypatch):
    figures: list = []
    made = plot._three
    monkeypatch.setattr(plot, "_three", lambda *a: figures.append(made(*a)) or figures[-1])
    write_plot(tmp_path / "a.svg", TIMES, ERRORS, "made")
    figure = figures[0]
    assert len(figure.axes) == 3
    assert all(axes.get_yscale() == axes.get_xscale() == "log" for axes in figure.axes)
    names = texts_of(figure)
    assert names.count("gather, over 20 s") == 2
    assert "accumulation 23" in names and "as the disc's area" in names
    assert names.count("diffusion") == 3
    for axes in figure.axes:
        boxes = [text.get_window_extent() for text in axes.texts if text.get_text() != ""]
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2)), names
        assert all(figure.bbox.x0 <= b.x0 and b.x1 <= figure.bbox.x1 for b in boxes)


def test_the_third_panel_is_of_much_blur_and_says_who_has_only_less():
    assert chosen_row(ERRORS).coc_px == 20.0
    without = ErrorRow(20.0, 0.002, {"diffusion": cell(4.0, 0.03), "gather": None})
    errors = replace(ERRORS, rows=(ERRORS.rows[0], without))
    figure = plot.figure_class()()
    trade_panel(figure.subplots(), errors)
    assert texts_of(figure) == ["diffusion", "gather, at 2 px"]


@pytest.mark.parametrize("done", [(), ("diffusion",)])
def test_who_was_never_done_is_in_no_panel(tmp_path, monkeypatch, done):
    times = {name: 1.0 if name in done else None for name in ("diffusion", "gather")}
    cells = {name: cell(1.0, 0.1) if name in done else None for name in times}
    figures: list = []
    made = plot._three
    monkeypatch.setattr(plot, "_three", lambda *a: figures.append(made(*a)) or figures[-1])
    rows = (MethodRow(2.0, times), MethodRow(20.0, times))
    errors = replace(ERRORS, rows=(ErrorRow(2.0, 0.0, cells), ErrorRow(20.0, 0.0, cells)))
    write_plot(tmp_path / "a.png", replace(TIMES, rows=rows), errors, "made")
    assert "gather" not in texts_of(figures[0])
    assert texts_of(figures[0]).count("diffusion") == 3 * len(done)


def test_the_dotted_line_is_four_times_as_much_for_twice_the_blur():
    figure = plot.figure_class()()
    axes = figure.subplots()
    time_panel(axes, TIMES)
    (line,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    (x0, x1), (y0, y1) = line.get_data()
    assert (x0, x1) == (2.0, 20.0) and y1 / y0 == pytest.approx(100.0)
    assert y1 == pytest.approx(200.0)  # beside gather, which grows most


def test_what_is_interrupted_while_it_is_written_leaves_the_old_plot(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")

    def interrupted(beside, **_) -> None:
        assert beside.parent == tmp_path and beside != path
        beside.write_bytes(b"half")
        raise KeyboardInterrupt

    figure = SimpleNamespace(savefig=interrupted, suptitle=lambda *_, **__: None)
    monkeypatch.setattr(plot, "_alone", lambda _: figure)
    with pytest.raises(KeyboardInterrupt):
        write_plot(path, TIMES, None, "made")
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_what_cannot_be_written_is_said(tmp_path):
    with pytest.raises(InputError, match="folder"):
        write_plot(tmp_path / "none" / "a.png", TIMES, None, "made")


@given(st.lists(st.floats(0, 1), max_size=9), st.floats(0.01, 0.3))
def test_names_are_spread_in_order_and_no_closer_than_the_gap(wanted, gap):
    placed = spread(wanted, gap)
    in_order = sorted(range(len(wanted)), key=lambda at: (placed[at], wanted[at]))
    assert [wanted[at] for at in in_order] == sorted(wanted)
    assert all(b - a >= gap * (1 - 1e-9) - 1e-12 for a, b in pairwise(sorted(placed)))
    assert sum(placed) == pytest.approx(sum(wanted), abs=1e-6)  # nobody is favoured


def test_names_that_have_room_stay_where_they_are():
    assert spread([0.9, 0.1, 0.5], 0.2) == pytest.approx([0.9, 0.1, 0.5])


@pytest.mark.parametrize("put", [name_lines, name_points])
def test_names_of_near_neighbours_do_not_cover_each_other(put):
    figure = plot.figure_class()(figsize=(8, 5))
    axes = figure.subplots()
    axes.set(xlim=(1, 1000), ylim=(0.01, 1), xscale="log", yscale="log")
    places = [(100, 0.1), (110, 0.1), (100, 0.11), (105, 0.095), (120, 0.105)]
    put(axes, [Label(f"accumulation {n}", *xy, "black") for n, xy in enumerate(places)])
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 5
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


@pytest.mark.usefixtures("ctx")
def test_the_command_draws_what_it_measured(capsys, tmp_path, monkeypatch, session_context):
    monkeypatch.setattr("heatlens.commands.bench.headless_context", lambda: session_context)
    monkeypatch.setattr(methods, "METHOD_COC_PX", (9.0,))
    path = tmp_path / "methods.png"
    words = ("bench", "--size", "64x48", "--runs", "1", "--views", "4", "--methods")
    truth = ("--truth-size", "48x27", "--truth-views", "70")
    assert main([*words, *truth, "--plot", str(path)]) == 0
    said = capsys.readouterr()
    assert f"heatlens: drawn to {path}" in said.err
    assert "methods at 64x48" in said.out and "errors at 48x27" in said.out
    with PillowImage.open(path) as image:
        assert image.format == "PNG"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--plot", "a.png"], "--methods"),
        (["--methods", "--plot", "a.jpg"], ".png or .svg"),
        (["--methods", "--plot", "nowhere/a.png"], "no folder nowhere"),
    ],
)
def test_a_plot_that_cannot_be_is_refused_before_anything_is_measured(capsys, words, said):
    assert main(["bench", *words]) == 2
    error = capsys.readouterr().err
    assert said in error and len(error.splitlines()) == 1


def test_a_missing_matplotlib_is_said_with_what_to_install(capsys, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["bench", "--methods", "--plot", str(tmp_path / "a.png")]) == 2
    assert "pip install 'heatlens[plot]'" in capsys.readouterr().err
