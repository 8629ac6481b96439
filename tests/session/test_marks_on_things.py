"""Marks on things of plates: picked by a click, measured on a thread, followed over frames."""

import pytest

from heatlens.model.coc import sharp_dioptres
from heatlens.model.marks import MatteMark, PointMark
from support.evening import begun, settled, until
from support.mattes import matte_plate

FIRST, COUNT = 1, 7
DISTANCES_M = {frame: 3.0 + 0.25 * frame for frame in range(FIRST, FIRST + COUNT)}
HIDDEN = 4


@pytest.fixture
def walk(tmp_path):
    """A session with a hero who walks away, behind something in the middle."""
    for frame, distance_m in DISTANCES_M.items():
        seen_m = None if frame == HIDDEN else distance_m
        matte_plate(tmp_path / f"walk.{frame:04d}.exr", seen_m)
    session = begun(tmp_path / "preferences", str(tmp_path / "walk.####.exr"))
    settled(session)
    yield session
    session.close()


def marked(session, pixel):
    session.time.marks.set_point(pixel)
    until(session, lambda: session.editing.shot.marks, "the mark")
    return session.editing.shot.marks[-1]


def test_a_click_on_a_thing_marks_the_thing(walk):
    hero = marked(walk, (14, 10))
    assert hero == MatteMark("A", "Crypto:hero")
    marks = walk.time.marks
    until(walk, lambda: marks.distance_m(hero) is not None, "its distance")
    assert marks.distance_m(hero) == pytest.approx(DISTANCES_M[FIRST], rel=1e-6)
    walk.editing.undo()
    assert walk.editing.shot.marks == ()


def test_a_click_beside_all_things_marks_the_point(walk):
    assert marked(walk, (2, 2)) == PointMark("A", 2.0, 2.0)


def test_the_distances_of_a_thing_are_drawn_with_a_gap_where_it_is_hidden(walk):
    marked(walk, (14, 10))

    def frames():
        (track,) = walk.time.mark_tracks()
        return [frame for line in track.lines for frame, _ in line]

    until(walk, lambda: len(frames()) == COUNT - 1, "all frames")
    assert frames() == [frame for frame in DISTANCES_M if frame != HIDDEN]


def test_the_focus_follows_a_thing_and_goes_on_while_it_is_hidden(walk):
    mark = marked(walk, (14, 10))
    walk.time.marks.follow(mark)
    until(walk, lambda: not walk.time.marks.is_reading, "all frames")
    assert "follows A" in walk.messages.text
    for frame, distance_m in DISTANCES_M.items():
        lens = walk.editing.shot.lens_at(frame)
        assert abs(1 / lens.focus_distance_m - 1 / distance_m) <= 0.51 * sharp_dioptres(lens)


def test_an_unknown_thing_is_told(walk):
    walk.time.marks.follow(MatteMark("Z", "cryptomatte:nobody"))
    until(walk, lambda: not walk.time.marks.is_reading, "the end")
    assert "nobody" in walk.messages.text and not walk.editing.shot.key_frames
