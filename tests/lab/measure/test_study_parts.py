"""Test the parts of a study: report folders, crops, measurement of scenes, and the chart."""

import json
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import GpuError, InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.lab.measure.chart import write_figure
from heatlens.lab.measure.study import measured
from heatlens.lab.measure.study import measured as references
from heatlens.lab.measure.study.folder import duration, report_folder, write_numbers
from heatlens.lab.measure.study.measured import Subject, measure_all
from heatlens.lab.measure.study.pictures import crop_boxes, crop_side, error_chart

LENS = Lens(50.0, 2.0, 2.0, 36.0)


# The folder


def write_report(path, *names: str) -> None:
    with report_folder(path) as folder:
        for name in names:
            (folder / name).write_text(name)
        write_numbers(folder, {}, list(names))


def test_report_folder_appears_only_when_complete(tmp_path):
    with report_folder(tmp_path / "r") as folder:
        (folder / "a").write_text("a")
        assert not (tmp_path / "r").exists() and folder.parent == tmp_path
    assert (tmp_path / "r" / "a").read_text() == "a"
    assert len(list(tmp_path.iterdir())) == 1


def test_report_may_replace_empty_folder(tmp_path):
    (tmp_path / "r").mkdir()
    write_report(tmp_path / "r", "a.png")
    assert sorted(p.name for p in (tmp_path / "r").iterdir()) == ["a.png", "study.json"]


def test_write_report_does_not_replace_folder_with_foreign_file(tmp_path):
    write_report(tmp_path / "r", "a.png")
    (tmp_path / "r" / "my notes").write_text("mine")
    with pytest.raises(InputError, match="my notes"):
        write_report(tmp_path / "r", "b.png")
    assert (tmp_path / "r" / "my notes").read_text() == "mine"


def test_report_is_not_replaced_if_file_is_added_meanwhile(tmp_path):
    write_report(tmp_path / "r", "a.png")
    with pytest.raises(InputError, match="late"), report_folder(tmp_path / "r"):
        (tmp_path / "r" / "late").write_text("mine")
    assert (tmp_path / "r" / "late").exists() and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    "record", ["", "[]", "{}", '{"files": ["a"]}', '{"heatlens_study": 1, "files": 3}', "[" * 9999]
)
def test_folder_with_invalid_record_is_not_replaced(tmp_path, record):
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "a").write_text("a")
    (tmp_path / "r" / "study.json").write_text(record)
    with pytest.raises(InputError, match="not a heatlens report"):
        write_report(tmp_path / "r", "b.png")


@pytest.mark.parametrize("name", ["thesis.doc", "sub", "linked.png", "Holiday.png"])
def test_folder_with_files_that_no_report_writes_is_not_replaced(tmp_path, name):
    """The record names a file, a folder or a link that would be deleted with the report."""
    folder = tmp_path / "report"
    folder.mkdir()
    if name == "sub":
        (folder / name).mkdir()
    elif name == "linked.png":
        (tmp_path / "elsewhere.png").write_text("x")
        (folder / name).symlink_to(tmp_path / "elsewhere.png")
    else:
        (folder / name).write_text("x")
    record = {"heatlens_study": 1, "files": [name, "study.json", "index.html", 3, None]}
    (folder / "study.json").write_text(json.dumps(record))
    files_before = sorted(folder.iterdir())
    with pytest.raises(InputError, match="not a heatlens report"), report_folder(folder):
        pass
    assert sorted(folder.iterdir()) == files_before


def test_report_folder_with_long_name_leaves_no_other_files(tmp_path):
    """A folder name of 250 letters leaves no room for the suffix of a temporary name."""
    folder = tmp_path / ("r" * 250)
    with report_folder(folder) as temporary_folder:
        write_numbers(temporary_folder, {}, [])
    assert [path.name for path in tmp_path.iterdir()] == [folder.name]


def test_report_folder_follows_symlink(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    write_report(tmp_path / "link", "a.png")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "real" / "a.png").exists()


def test_write_numbers_rejects_nan(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_numbers(tmp_path, {"flip": float("nan")}, [])
    write_numbers(tmp_path, {"flip": 0.5}, ["a"])
    assert json.loads((tmp_path / "study.json").read_text())["files"] == ["a", "study.json"]


# The crops


@given(st.integers(7, 90), st.integers(7, 90), st.integers(0, 2**32 - 1))
def test_crop_boxes_lie_inside_and_do_not_overlap(height, width, seed):
    rng = np.random.default_rng(seed)
    truth, *pictures = rng.random((3, height, width, 3), np.float32)
    boxes = crop_boxes(pictures, truth)
    side, crop_counts = crop_side(height, width), np.zeros((height, width), int)
    assert 1 <= len(boxes) <= 3
    for box in boxes:
        assert box.shape == (side, side)
        assert box.intersection(Box(0, 0, width, height)) == box
        crop_counts[box.y0 : box.y1, box.x0 : box.x1] += 1
    assert crop_counts.max() == 1


def test_first_crop_covers_largest_difference_between_methods():
    truth = np.full((100, 100, 3), 0.2, np.float32)
    good, bad = truth.copy(), truth.copy()
    good[:40, :40] = bad[:40, :40] = 1.0
    bad[70:80, 60:70] = 0.5
    box = crop_boxes([good, bad], truth)[0]
    assert box.x0 <= 60 and box.x1 >= 70 and box.y0 <= 70 and box.y1 >= 80


# The order in which things are measured


@dataclass
class FakeSceneRenderer:
    """A fake scene renderer whose methods continue with the views that they already have.

    A picture from n views is off by 1/n. Asking again for the same lens costs nothing new.
    """

    methods: tuple = tuple(Method)
    ctx: object = field(default_factory=lambda: SimpleNamespace(finish=lambda: None))
    sums: dict = field(default_factory=dict)
    drawn: list = field(default_factory=list)

    def render(self, shot, frame=0):
        method, views = shot.defocus.method, shot.defocus.views
        if method is Method.SCATTER:
            raise GpuError("There is no room.")
        if not method.needs_scene:
            return 0.5
        lens, count = self.sums.get(method, (None, 0))
        count = count if lens == shot.lens else 0
        self.drawn.append((method, max(0, views - count)))
        self.sums[method] = (shot.lens, max(count, views))
        return 1.0 + 1.0 / max(count, views)

    def steps(self, shot, frame=0):
        yield "view"
        return np.full((9, 9, 4), self.render(shot, frame) - 0.4, np.float32)


def fake_pixel(views: int) -> float:
    """Return each value of a picture of the fake scene renderer from so many views."""
    return 0.6 + 1 / views


@pytest.fixture(autouse=True)
def pictures_need_no_gpu(monkeypatch):
    monkeypatch.setattr("heatlens.lab.measure.study.measured.download", lambda pixels: pixels)


def truth_from(subject: Subject, views: int) -> references.Reference:
    return references.from_views(subject, views, lambda _: None)


def scene_subject(views: int = 8) -> Subject:
    return Subject("a scene", FakeSceneRenderer(), Shot(LENS, DefocusSettings(views=views)), 3)


def test_measure_all_uses_view_count_of_each_method():
    subject = scene_subject(views=8)
    truth = truth_from(subject, views=1024)
    rows = measure_all(subject, (Method.ACCUMULATION,), truth, 2, lambda _: None).rows
    assert truth.pixels[0, 0, 0] == pytest.approx(fake_pixel(views=1024), rel=1e-6)
    assert rows[0].pixels[0, 0, 0] == pytest.approx(fake_pixel(views=8), rel=1e-6)
    assert rows[0].detail == "8 views"


def test_every_timed_frame_is_rendered_from_scratch():
    subject = scene_subject(views=8)
    truth = truth_from(subject, views=64)
    measure_all(subject, (Method.RAYTRACED,), truth, runs=3, report_progress=lambda _: None)
    traced = [views for method, views in subject.renderer.drawn if method is Method.RAYTRACED]
    warm_up_and_runs = 4
    assert traced == [1, 8] * warm_up_and_runs  # one view of another lens drops the views before


def test_measure_all_skips_method_that_does_not_fit_with_message():
    subject, messages = scene_subject(), []
    truth = truth_from(subject, 64)
    result = measure_all(subject, (Method.SCATTER, Method.HEAT), truth, 1, messages.append)
    assert [row.method for row in result.rows] == [Method.HEAT]
    assert result.left_out == ("scatter is skipped: There is no room.",) and messages[1:2] == [
        *result.left_out
    ]
    with pytest.raises(GpuError, match="no room"):
        measure_all(subject, (Method.SCATTER,), truth, 1, messages.append)


def test_measure_all_reports_time_of_warm_up_if_no_time_is_left_for_runs(monkeypatch):
    monkeypatch.setattr(measured, "LIMIT_S", 0.0)
    subject = scene_subject()
    truth = truth_from(subject, views=4)
    (row,) = measure_all(
        subject, (Method.HEAT,), truth, runs=5, report_progress=lambda _: None
    ).rows
    assert row.runs == 0 and row.seconds > 0


# How it is shown


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.0000123, "0.0123 ms"),
        (0.8124, "812 ms"),
        (0.9999, "1 s"),
        (1.239, "1.24 s"),
        (5e3, "5000 s"),
    ],
)
def test_duration_has_three_digits(seconds, words):
    assert duration(seconds) == words


METHODS = st.sampled_from(list(Method))
MEASURED = st.tuples(METHODS, st.floats(0, 1), st.floats(0, 1e4))


@given(st.lists(MEASURED, min_size=1, max_size=7))
@settings(max_examples=15)
def test_error_chart_plots_each_method_at_its_values(values):
    rows = [
        SimpleNamespace(method=method, seconds=seconds, scores=SimpleNamespace(flip=flip))
        for method, flip, seconds in values
    ]
    figure = error_chart(rows, rows[0])
    (axes,) = figure.axes
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert high / low >= 9.99 and bottom == 0
    for row, line in zip(rows, axes.lines, strict=True):
        ((ms,), (flip,)) = line.get_data()
        assert ms == max(1e3 * row.seconds, 1e-3) and flip == row.scores.flip
        assert low <= ms <= high and bottom <= flip <= top
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    by_error = sorted(rows, key=lambda row: -row.scores.flip)
    assert [name.partition(",")[0] for name in names] == [str(row.method) for row in by_error]
    assert sum(name.endswith(", the closest") for name in names) == 1


def test_error_chart_file_is_reproducible(tmp_path):
    row = SimpleNamespace(method=Method.HEAT, seconds=1.0, scores=SimpleNamespace(flip=0.2))
    for name in ("a.svg", "b.svg"):
        write_figure(tmp_path / name, error_chart([row], row))
    text = (tmp_path / "a.svg").read_text()
    assert text == (tmp_path / "b.svg").read_text()
    assert ">heat, the closest<" in text  # letters, which can be read aloud, not outlines
