"""What joins the parts of a session: playback, the command line, lessons, comparison."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import FaultError, InputError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import Against, Compare
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.color.color_config import load_color_config
from heatlens.media.documents.lens_kits import kit_shelf
from heatlens.media.documents.shot_file import autosave_path, read_shot
from heatlens.media.scene.scene_read import DEMO
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.textures import download
from heatlens.render.preview.level_choice import quickest
from heatlens.studio.session.keys.key_choice import all_keys
from heatlens.studio.session.keys.key_commands import KeyCommands
from heatlens.studio.session.keys.key_drag import Ends, KeyStretch
from heatlens.studio.session.keys.key_rows import RowChoice
from heatlens.studio.session.marks.lessons import Lesson, Lessons
from heatlens.studio.session.pictures.look_pictures import LookPictures
from heatlens.studio.session.session import Session
from heatlens.studio.session.settings.preferences import Preferences
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.session.shot.shot_store import unnamed_path
from heatlens.studio.session.shot.start import Start
from support.evening import (
    FIRST,
    LAST,
    LEFT,
    RIGHT,
    begun,
    session_of,
    settled,
    turn,
    until,
    write_plates,
)
from support.fake_renderer import FakeRenderer
from support.session_files import QUICK, room_file, write_scene
from support.shared import shared_of

FOCUS = LensParameter.FOCUS_DISTANCE
KEYED = Shot(Lens(50.0, 2.8, 2.0, 36.0)).with_key(10, FOCUS, 2.0).with_key(20, FOCUS, 4.0)


# Playback


def test_playback_shows_each_frame_in_its_time(walls):
    now = [50.0]
    timeline = walls.time.timeline
    timeline.playback._clock = lambda: now[0]
    seen = []
    timeline.play(1)
    assert not walls.time.player.is_due
    while len(seen) < 5:
        until(walls, lambda: walls.source.is_settled_at(walls.editing.frame), "the plate")
        seen.append(walls.editing.frame)
        now[0] += 1.01 / 24.0
        assert walls.time.player.is_due
        walls.poll()
    assert seen == list(range(FIRST, FIRST + 5))
    timeline.play(1)
    assert not walls.time.player.is_due
    assert walls.time.player.seconds_until_needed() is None


def test_a_frame_that_cannot_be_shown_says_so_once(tmp_path):
    pattern = write_plates(tmp_path)
    (tmp_path / f"walls.{FIRST + 3}.exr").write_bytes(b"damaged")
    (tmp_path / f"walls.{FIRST + 6}.exr").unlink()
    session = begun(tmp_path / "preferences", pattern)
    settled(session)
    try:
        session.time.timeline.go(FIRST + 3)
        until(session, lambda: f"walls.{FIRST + 3}" in session.messages.text, "the reason")
        session.messages.clear()
        for _ in range(5):
            turn(session)
        assert not session.messages.text
        session.time.timeline.go(FIRST + 6)
        session.time.timeline.missing = "black"
        turn(session)
        assert session.facts.is_black and session.source.is_settled_at(FIRST + 6)
        session.time.timeline.missing = "stop"
        turn(session)
        assert not session.facts.is_black and "is missing" in session.source.picture.problem
    finally:
        session.close()


# What the command line gives


def test_a_camera_of_the_command_line_is_for_the_first_source(tmp_path):
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n1001,35,4,3\n1010,35,4,5\n")
    camera = read_camera(str(table))
    session = session_of(
        tmp_path, source=write_plates(tmp_path), camera=camera, lens={"f_stop": 8.0}
    )
    settled(session)
    try:
        lens = session.facts.lens
        assert (lens.focal_length_mm, lens.f_stop) == (35.0, 8.0)
        assert session.editing.shot.lens_at(1010).focus_distance_m == pytest.approx(5.0)
        path = str(room_file(tmp_path / "still.exr", 8, 6))
        session.files.commands.open(path)
        until(session, lambda: session.editing.shot.source == path, "another source")
        assert session.facts.lens.focal_length_mm != 35.0
    finally:
        session.close()


def test_a_camera_beside_an_impossible_lens_is_left_out_with_it(tmp_path):
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n1001,35,4,3\n1010,35,4,5\n")
    lens = {"focal_length_mm": 6000.0}
    source, camera = str(room_file(tmp_path / "a.exr", 8, 6)), read_camera(str(table))
    session = session_of(tmp_path, source=source, camera=camera, lens=lens)
    settled(session)
    try:
        assert session.facts.lens.focal_length_mm == 85.0 and not session.editing.shot.key_frames
        assert "6000" in session.messages.text
    finally:
        session.close()


def test_a_still_takes_the_frames_of_the_camera(tmp_path):
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n41,35,4,3\n50,35,4,5\n")
    still = room_file(tmp_path / "still.exr", 8, 6)
    session = session_of(tmp_path, source=str(still), camera=read_camera(str(table)))
    settled(session)
    try:
        assert session.editing.frame == 41 and session.editing.shot.frames.count == 10
    finally:
        session.close()


def test_an_impossible_lens_of_the_command_line_is_left_out_and_told(tmp_path):
    lens = {"focal_length_mm": 3000.0, "focus_distance_m": 1.0}
    session = session_of(tmp_path, source=str(room_file(tmp_path / "a.exr", 8, 6)), lens=lens)
    settled(session)
    try:
        assert session.facts.lens.focal_length_mm == 85.0  # that of the header
        assert "3000" in session.messages.text
    finally:
        session.close()


def test_a_kit_of_the_command_line_limits_the_first_lens(tmp_path):
    kit = next(iter(kit_shelf().kits.values()))
    session = session_of(tmp_path, source=str(room_file(tmp_path / "a.exr", 8, 6)), kit=kit)
    settled(session)
    try:
        assert session.editing.shot.kit == kit
        mounted = session.lens.commands.kits.mounted
        assert session.facts.lens.focal_length_mm == mounted.length_near(85.0)
        assert session.facts.lens.f_stop >= mounted.f_stop
    finally:
        session.close()


def test_options_of_the_command_line_go_over_the_remembered_ones(tmp_path):
    still = str(room_file(tmp_path / "a.exr", 8, 6))
    kept = Preferences.load(tmp_path / "preferences")
    kept.read_so(tmp_path, PlateOptions(scene_unit_m=0.5))
    renderer = FakeRenderer()
    for given, found in (
        (PlateOptions(), PlateOptions(scene_unit_m=0.5)),
        (PlateOptions(scene_unit_m=2.0), PlateOptions(scene_unit_m=2.0)),
        (
            PlateOptions(sensor_width_mm=20.0),
            PlateOptions(scene_unit_m=0.5, sensor_width_mm=20.0),
        ),
    ):
        session = Session(renderer, Start(still, plate_options=given), preferences=kept)
        session.begin()
        settled(session)
        assert session.source.opened.options == found
        session.close()


# Faults, and what is drawn


def test_a_fault_of_the_program_keeps_the_shot_first(walls, tmp_path):
    walls.editing.edit(replace(walls.editing.shot, looks=(Look("A", walls.facts.lens),)))
    walls.say_error(InputError("a file"))
    kept = autosave_path(unnamed_path(tmp_path / "preferences", walls.editing.shot.source))
    assert not kept.exists() and walls.messages.text == "a file"
    walls.say_error(FaultError("a fault"))
    assert read_shot(kept).looks[0].name == "A" and walls.messages.text == "a fault"


def test_the_ring_learns_what_is_on_the_screen(walls):
    seen = []
    walls.lens.ring.seen = seen.append
    walls.drawn()
    assert seen == [walls.facts.seen.shot.lens_at(walls.facts.seen.frame)]


def test_facts_are_those_of_the_parts(walls):
    facts, pictures = walls.facts, walls.pictures
    assert facts.seen_shot == walls.editing.seen_shot and facts.unit == "m" and facts.has_lens
    assert facts.plate is walls.source.plate and facts.histogram is walls.source.picture.histogram
    assert facts.reference is None is facts.stream and facts.opening == ""
    assert facts.is_plain and not facts.plays_kept and not facts.has_camera
    assert (facts.picture_shape.width_px, facts.picture_shape.height_px) == (48, 32)
    data, display = facts.windows()
    assert data == display == facts.plate.display_window
    assert facts.frame_px(LEFT) == LEFT == facts.plate_px(LEFT)
    assert facts.picture_point((3.5, 4.5)) == (3.5, 4.5)
    pictures.commands.toggle_compare(Compare.WIPE)
    assert not facts.is_plain
    walls.files.commands.open("not_there.exr")
    assert facts.opening == "not_there.exr"


def test_preferences_of_the_view_are_remembered_without_what_belongs_to_a_source(walls, tmp_path):
    view = walls.pictures.commands
    view.toggle_unit()
    view.toggle_guide("thirds")
    view.change(guides=replace(walls.facts.view.guides, desqueeze=2.0))
    walls.time.timeline.playback.is_every_frame = not walls.preferences.now.every_frame
    walls.remember()
    settled(walls)
    kept = Preferences.load(tmp_path / "preferences").now
    assert kept.unit == "ft" and kept.guides.thirds and kept.guides.desqueeze is None
    assert kept.every_frame is walls.time.timeline.playback.is_every_frame


def test_the_loop_sleeps_until_something_is_needed(walls):
    settled(walls)
    walls.messages.clear()
    assert not walls.wants_frames
    walls.editing.edit(replace(walls.editing.shot, looks=(Look("A", walls.facts.lens),)))
    assert walls.wants_frames and walls.seconds_until_needed() <= 0.1
    walls.messages.say("A word.")
    assert walls.seconds_until_needed() is not None


# Lessons


def test_a_gesture_that_was_done_is_taught_no_more():
    editing = Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0), source=DEMO), lambda _text: None)
    marks = SimpleNamespace(pulls=SimpleNamespace(made=3))
    lessons = Lessons(editing, marks)
    lessons.watch(is_dragging=True, is_pressed=True)
    assert lessons.left == tuple(Lesson)

    def focus(distance_m):
        editing.edit_lens(replace(editing.lens, focus_distance_m=distance_m))

    focus(3.0)
    lessons.watch(is_dragging=False, is_pressed=False)  # by a key
    assert lessons.left == tuple(Lesson)
    focus(4.0)
    lessons.watch(is_dragging=False, is_pressed=True)
    assert lessons.left == (Lesson.DRAG, Lesson.PULL)
    editing.frame = 7
    focus(5.0)
    lessons.watch(is_dragging=True, is_pressed=False)  # another frame has its own focus
    assert Lesson.DRAG in lessons.left
    focus(6.0)
    lessons.watch(is_dragging=True, is_pressed=True)
    assert lessons.left == (Lesson.PULL,)
    marks.pulls.made = 4
    lessons.watch(is_dragging=False, is_pressed=False)
    assert lessons.left == ()
    other = Lessons(editing, marks)
    assert other.left == tuple(Lesson)
    other.is_dismissed = True
    assert other.left == ()
    own = Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0), source="mine.exr"), lambda _text: None)
    assert Lessons(own, marks).left == ()


# Stretching by hand


def test_an_end_of_the_chosen_keys_is_dragged():
    said = []
    editing = Editing(KEYED.with_key(30, FOCUS, 6.0), said.append)
    keys = KeyCommands(shared_of(editing, said.append), RowChoice(lambda: False), lambda: None)
    hand = KeyStretch(editing, keys, said.append)
    hand.press(is_last=True)
    hand.drag(25)
    assert hand.ends is None and editing.shot == KEYED.with_key(30, FOCUS, 6.0)
    keys.choose_between(FOCUS, 10, 20)
    assert hand.ends == Ends(10, 20)
    hand.press(is_last=True)
    hand.drag(40)
    assert [key.frame for key in editing.shot.curves.of(FOCUS).keys] == [10, 30, 40] or (
        hand.ends == Ends(10, 40)
    )
    hand.drag(2)
    assert hand.ends == Ends(10, 11)
    hand.drag(30)
    hand.release()
    assert "gave way" in said[-1] and hand.ends == Ends(10, 30)
    editing.undo()
    assert len(all_keys(editing.shot)) == 3
    keys.choose_between(FOCUS, 10, 20)
    hand.press(is_last=False)
    hand.drag(25)
    assert hand.ends == Ends(19, 20)
    hand.drag(4)
    hand.release()
    assert hand.ends == Ends(4, 20) and not editing.is_unsettled


# Comparison and colour


def test_b_is_the_shot_by_another_method(ctx, renderer, tmp_path):
    path = str(room_file(tmp_path / "room.exr", 32, 24))
    session = session_of(tmp_path, renderer, source=path, defocus=QUICK)
    settled(session)
    try:
        sides, view = session.pictures.sides, session.pictures.commands
        view.compare_with(Method.GATHER)
        until(session, lambda: sides.of_method(session.facts.view) is not None, "B")
        settled(session)
        shot = session.editing.shot
        gathered = replace(shot, defocus=replace(shot.defocus, method=Method.GATHER))
        made = download(sides.of_method(session.facts.view).texture)
        np.testing.assert_allclose(made, renderer.pixels(gathered), atol=2e-3, rtol=2e-3)
        view.compare_with(Method.RAYTRACED)  # which needs a scene
        assert sides.of_method(session.facts.view) is None
        wide = replace(session.facts.lens, f_stop=8.0)
        session.editing.do(replace(shot, looks=(Look("A", session.facts.lens), Look("B", wide))))
        session.pictures.looks.compare(session.editing.shot.looks[1])
        until(session, lambda: sides.of_method(session.facts.view) is not None, "the look")
        settled(session)
        assert not sides.is_coming("B")
        session.pictures.looks.compare_as_a(session.editing.shot.looks[0])
        turn(session)
        assert sides.of_a(session.facts.view) is sides.a.shown  # it is the lens as it is
        assert not sides.is_coming("A")
        view.change(against=Against.PINHOLE)
        turn(session)
        assert sides.of_a(session.facts.view) is None and sides.rendered == (sides.a,)
    finally:
        session.close()


def test_looks_of_a_scene_are_drawn_with_their_own_field_of_view(ctx, renderer, tmp_path):
    path = str(write_scene(tmp_path / "scene.glb"))
    session = session_of(tmp_path, renderer, source=path, defocus=QUICK)
    until(session, lambda: session.source.opened is not None, "the scene")
    small = replace(session.editing.shot.framing, width_px=32, height_px=20)
    shot = replace(session.editing.shot, framing=small)
    long = replace(shot.lens, focal_length_mm=2 * shot.lens.focal_length_mm)
    wide = replace(shot.lens, focal_length_mm=0.7 * shot.lens.focal_length_mm)
    session.editing.begin(replace(shot, looks=(Look("A", long), Look("B", wide))))
    try:
        session.pictures.looks.toggle_grid()
        looks: LookPictures = session.pictures.sides.looks
        turn(session)
        quick = looks._tiles["A"].quick_key
        assert quick.shot.framing.size == (8, 5) and quick.settings == quickest(QUICK)
        until(session, lambda: None not in (looks.of("A"), looks.of("B")), "both")
        until(session, lambda: not (looks.is_coming("A") or looks.is_coming("B")), "both, whole")
        settled(session)
        for look in session.editing.shot.looks:
            seen = looks.of(look.name)
            assert seen.texture.size == (32, 20)
            through = session.editing.shot.through(look)
            own = renderer.pixels(through, session.editing.frame)
            assert np.abs(download(seen.texture) - own).mean() < 0.01
        session.pictures.looks.toggle_grid()
        turn(session)
        assert looks.shown == () and not looks.is_working
    finally:
        session.close()


def test_the_colours_of_the_screen_are_made_anew_where_names_change(ctx, walls):
    color, screen = walls.pictures.color, ScreenPictures(ctx)
    view = color.with_names(walls.facts.view)
    color.apply(view, screen)
    assert screen.transform_version == 1
    made = color.transform
    color.apply(view, screen)
    assert screen.transform_version == 1 and color.transform is made
    (*_, other) = load_color_config(None).views(view.display)
    color.apply(replace(view, view=other), screen)
    assert screen.transform_version == 2 and color.transform is not made
    color.draw_again()
    color.apply(replace(view, view=other), screen)
    assert screen.transform_version == 3
    made = color.transform
    color.apply(replace(view, view="no such view"), screen)
    assert walls.messages.text and color.transform is made  # the last good one stays


def test_a_look_for_a_file_is_that_of_the_screen(walls, ctx):
    view = walls.pictures.commands
    view.expose(4)
    view.change(gamma=2.0)
    display = walls.files.exports._look
    options = display.options()
    assert options.exposure_stops == 1.0 and options.gamma == 2.0
    assert options.display == walls.facts.view.display and options.view == walls.facts.view.view
    walls.editing.edit_lens(
        replace(walls.facts.lens, t_stop=walls.facts.lens.f_stop * math.sqrt(2))
    )
    assert display.options().exposure_stops == pytest.approx(0.0)
    light = np.full((2, 2, 3), 0.18, np.float32)
    brighter = display.values(ctx).encode(light)
    view.expose(-4)
    assert (display.values(ctx).encode(light) < brighter).all()


def test_tracks_and_marks_of_a_stretch_hold_their_interpolation(walls):
    walls.time.marks.set_point(LEFT)
    walls.time.marks.set_point(RIGHT)
    assert isinstance(walls.editing.shot.marks[0], PointMark)
    walls.time.marks.pulls.lengthen(LAST - FIRST)
    walls.time.marks.pulls.make()
    until(walls, lambda: not walls.time.marks.distances.is_waited_for, "the pull")
    walls.time.keys.choose_all()
    walls.time.keys.interpolate(Interpolation.LINEAR)
    keys = walls.editing.shot.curves.of(FOCUS).keys
    assert {key.interpolation for key in keys} == {Interpolation.LINEAR}
