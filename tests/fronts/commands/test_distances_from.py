"""Distances from the film plane are kept from the entrance pupil, and told as they were given."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import Lens, MeasuredFrom
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance
from heatlens.deliver.export.sheet_rows import sheet_row
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.live.ring.sources import Heard, LensSample, RingSources
from heatlens.studio.session.live.ring_hand import RingHand
from heatlens.studio.session.shot.editing import Editing

SHOT = ("shot", "new", "no.####.exr", "--focal-length", "50", "--sensor-width", "36")
FILM = ("--distances-from", "film-plane", "--pupil-offset", "120")


@pytest.fixture
def made(tmp_path, capsys):
    def make(*options: str):
        path = tmp_path / "s.heatlens.json"
        code = main([*SHOT, "--f-stop", "2", "-o", str(path), "--overwrite", *options])
        return (read_shot(path) if code == 0 else code), capsys.readouterr().err

    return make


def test_focus_keys_marks_and_close_focus_begin_at_the_film_plane(made):
    shot, _ = made(*FILM, "--key", "focus@1=2.12", "--key", "focus@9=3.12", "--mark", "A=1.12")
    assert shot.lens.measured_from is MeasuredFrom.FILM
    assert [shot.lens_at(f).focus_distance_m for f in (1, 9)] == pytest.approx([2.0, 3.0])
    assert shot.marks[0].distance_m == pytest.approx(1.0)
    shot, _ = made(*FILM, "--focus-distance", "2.12", "--close-focus", "0.57")
    assert shot.lens.focus_distance_m == pytest.approx(2.0)
    assert shot.lens.close_focus_m == pytest.approx(0.45)


def test_a_table_of_a_shoot_is_measured_likewise(made, tmp_path):
    table = tmp_path / "take.csv"
    table.write_text("frame,focus (m),f-stop\n1,2.12,2\n2,3.12,2\n")
    shot, _ = made(*FILM, "--lens-from", str(table))
    assert [shot.lens_at(f).focus_distance_m for f in (1, 2)] == pytest.approx([2.0, 3.0])


def test_what_cannot_be_is_explained(made):
    code, said = made("--focus-distance", "2", "--pupil-offset", "120")
    assert code == 2 and "--distances-from film-plane" in said
    code, said = made(*FILM, "--focus-distance", "0.1")
    assert code == 2 and "behind an entrance pupil" in said


def test_the_focus_is_said_from_where_it_is_measured(tmp_path, capsys, monkeypatch):
    from heatlens.fronts.commands.options.lens_options import lens_words

    lens = Lens(50.0, 2.0, 2.0, 36.0, measured_from=MeasuredFrom.FILM, pupil_offset_mm=120.0)
    names = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m", "model")
    assert "focus 2.12 m" in lens_words(lens, dict.fromkeys(names, "given"))


@pytest.mark.parametrize(
    ("start", "told_mm", "focus_m"),
    [
        (MeasuredFrom.PUPIL, 120.0, 2.12),
        (MeasuredFrom.FILM, 120.0, 2.0),
        (MeasuredFrom.FILM, None, 2.02),  # the lens says 100 mm
    ],
)
def test_a_ring_is_read_as_the_lens_is_measured(start, told_mm, focus_m):
    lens = Lens(50.0, 2.0, 5.0, 36.0, measured_from=start, pupil_offset_mm=100.0)
    editing = Editing(Shot(lens), lambda _: None)

    class Ring:
        sources = RingSources(lambda: 0.0)

        def heard(self, source: str | None) -> Heard:
            return self.sources.heard(source)

    ring = Ring()
    ring.sources = RingSources(lambda: 0.0)
    ring.sources.keep(LensSample("A", focus_distance_m=2.12, pupil_offset_mm=told_mm))
    RingHand(ring, editing, print).poll()
    assert editing.lens.focus_distance_m == pytest.approx(focus_m)


def test_the_sheet_and_the_list_of_a_shot_tell_what_the_panel_tells(tmp_path, capsys):
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
