"""Test distances typed from the film plane, which are stored from the entrance pupil."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import Lens, MeasuredFrom
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.deliver.export.sheet_rows import sheet_row
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.live.ring.sources import LensSample, RingSources, SourceState
from heatlens.studio.session.live.ring_follower import RingFollower
from heatlens.studio.session.shot.editing import Editing

SHOT = ("shot", "new", "no.####.exr", "--focal-length", "50", "--sensor-width", "36")
FILM = ("--distances-from", "film-plane", "--pupil-offset", "120")


@pytest.fixture
def make_shot(tmp_path, capsys):
    def make(*options: str):
        path = tmp_path / "s.heatlens.json"
        code = main([*SHOT, "--f-stop", "2", "-o", str(path), "--overwrite", *options])
        return (read_shot(path) if code == 0 else code), capsys.readouterr().err

    return make


def test_distances_from_film_plane_apply_to_keys_marks_and_close_focus(make_shot):
    shot, _ = make_shot(*FILM, "--key", "focus@1=2.12", "--key", "focus@9=3.12", "--mark", "A=1.12")
    assert shot.lens.measured_from is MeasuredFrom.FILM
    assert [shot.lens_at(f).focus_distance_m for f in (1, 9)] == pytest.approx([2.0, 3.0])
    assert shot.marks[0].distance_m == pytest.approx(1.0)
    shot, _ = make_shot(*FILM, "--focus-distance", "2.12", "--close-focus", "0.57")
    assert shot.lens.focus_distance_m == pytest.approx(2.0)
    assert shot.lens.close_focus_m == pytest.approx(0.45)


def test_distances_from_film_plane_apply_to_shoot_table(make_shot, tmp_path):
    table = tmp_path / "take.csv"
    table.write_text("frame,focus (m),f-stop\n1,2.12,2\n2,3.12,2\n")
    shot, _ = make_shot(*FILM, "--lens-from", str(table))
    assert [shot.lens_at(f).focus_distance_m for f in (1, 2)] == pytest.approx([2.0, 3.0])


def test_shot_new_rejects_impossible_pupil_offset(make_shot):
    code, message = make_shot("--focus-distance", "2", "--pupil-offset", "120")
    assert code == 2 and "--distances-from film-plane" in message
    code, message = make_shot(*FILM, "--focus-distance", "0.1")
    assert code == 2 and "nearer than the entrance pupil" in message


def test_lens_words_give_focus_from_film_plane(tmp_path, capsys, monkeypatch):
    from heatlens.fronts.commands.options.lens_options import lens_words

    lens = Lens(50.0, 2.0, 2.0, 36.0, measured_from=MeasuredFrom.FILM, pupil_offset_mm=120.0)
    names = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m", "model")
    assert "focus 2.12 m" in lens_words("lens", lens, dict.fromkeys(names, "given"))


@pytest.mark.parametrize(
    ("start", "sample_offset_mm", "focus_m"),
    [
        (MeasuredFrom.PUPIL, 120.0, 2.12),
        (MeasuredFrom.FILM, 120.0, 2.0),
        (MeasuredFrom.FILM, None, 2.02),  # the lens says 100 mm
    ],
)
def test_ring_focus_is_converted_from_measured_origin(start, sample_offset_mm, focus_m):
    lens = Lens(50.0, 2.0, 5.0, 36.0, measured_from=start, pupil_offset_mm=100.0)
    editing = Editing(Shot(lens), lambda _: None)

    class Ring:
        sources = RingSources(lambda: 0.0)

        def source_state(self, source: str | None) -> SourceState:
            return self.sources.source_state(source)

        def listen(self, on_news: object) -> None:
            """Do nothing: the sample is there before anybody listens."""

    ring = Ring()
    ring.sources = RingSources(lambda: 0.0)
    ring.sources.add_sample(
        LensSample("A", focus_distance_m=2.12, pupil_offset_mm=sample_offset_mm)
    )
    RingFollower(receiver=ring, editing=editing, notify=print).poll()
    assert editing.lens.focus_distance_m == pytest.approx(focus_m)


def test_sheet_and_shot_show_give_distances_from_film_plane(tmp_path, capsys):
    film = Lens(50.0, 2.8, 2.0, 36.0, measured_from=MeasuredFrom.FILM, pupil_offset_mm=120.0)
    shot = Shot(film, frames=FrameRange(1, 2))
    row = sheet_row(shot, 1.0, 1, ())
    assert row.focus == "2.12 m"
    assert row.near == format_distance(near_limit_m(film) + 0.12)
    assert row.far == format_distance(far_limit_m(film) + 0.12)
    path = tmp_path / "s.heatlens.json"
    write_shot(path, shot)
    assert main(["shot", "show", str(path)]) == 0
    text = capsys.readouterr().out
    assert "2.120 m" in text and "from the film plane" in text
