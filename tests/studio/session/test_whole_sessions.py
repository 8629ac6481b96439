"""What joins the parts of a session: playback, the command line, lessons, comparison."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import FaultError, InputError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.keys.key_choice import all_keys
from heatlens.core.model.keys.key_rows import RowChoice
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
from heatlens.media.documents.shot_file import autosave_path, read_shot, unnamed_path
from heatlens.media.scene.scene_read import DEMO
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.gpu.textures import download
from heatlens.render.preview.level_choice import fastest_settings
from heatlens.studio.board.key_drag import Ends, KeyStretch
from heatlens.studio.board.lessons import Lesson, Lessons
from heatlens.studio.board.session import Session
from heatlens.studio.session.keys.key_commands import KeyCommands
from heatlens.studio.session.pictures.look_pictures import LookPictures
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.evening import (
    FIRST,
    LAST,
    LEFT,
    RIGHT,
    begin_session,
    run_loop_once,
    run_until,
    run_until_settled,
    session_of,
    write_plates,
)
from support.fake_renderer import FakeRenderer
from support.session_files import QUICK, room_file, write_scene
from support.shared import shared_of

FOCUS = LensParameter.FOCUS_DISTANCE
KEYED = Shot(Lens(50.0, 2.8, 2.0, 36.0)).with_key(10, FOCUS, 2.0).with_key(20, FOCUS, 4.0)


# Playback


def test_playback_shows_each_frame_when_it_is_due(session):
    clock_s = [50.0]
    timeline = session.time.timeline
    timeline.playback._clock = lambda: clock_s[0]
    shown_frames = []
    timeline.play(1)
    assert not session.time.player.is_due
    while len(shown_frames) < 5:
        run_until(session, lambda: session.source.is_settled_at(session.editing.frame), "the plate")
        shown_frames.append(session.editing.frame)
        clock_s[0] += 1.01 / 24.0
        assert session.time.player.is_due
        session.poll()
    assert shown_frames == list(range(FIRST, FIRST + 5))
    timeline.play(1)
    assert not session.time.player.is_due
    assert session.time.player.seconds_until_needed() is None


def test_damaged_frame_is_reported_once_and_missing_frame_by_setting(tmp_path):
    pattern = write_plates(tmp_path)
    (tmp_path / f"walls.{FIRST + 3}.exr").write_bytes(b"damaged")
    (tmp_path / f"walls.{FIRST + 6}.exr").unlink()
    session = begin_session(tmp_path / "preferences", pattern)
    run_until_settled(session)
    try:
        session.time.timeline.go_to(FIRST + 3)
        run_until(session, lambda: f"walls.{FIRST + 3}" in session.messages.text, "the reason")
        session.messages.clear()
        for _ in range(5):
            run_loop_once(session)
        assert not session.messages.text
        session.time.timeline.go_to(FIRST + 6)
        session.time.timeline.missing = "black"
        run_loop_once(session)
        assert session.facts.is_black and session.source.is_settled_at(FIRST + 6)
        session.time.timeline.missing = "stop"
        run_loop_once(session)
        assert not session.facts.is_black and "is missing" in session.source.picture.problem
    finally:
        session.close()


# What the command line gives


def test_command_line_camera_applies_only_to_the_first_source(tmp_path):
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n1001,35,4,3\n1010,35,4,5\n")
    camera = read_camera(str(table))
    session = session_of(
        tmp_path, source=write_plates(tmp_path), camera=camera, lens={"f_stop": 8.0}
    )
    run_until_settled(session)
    try:
        lens = session.facts.lens
        assert (lens.focal_length_mm, lens.f_stop) == (35.0, 8.0)
        assert session.editing.shot.lens_at(1010).focus_distance_m == pytest.approx(5.0)
        path = str(room_file(tmp_path / "still.exr", 8, 6))
        session.files.commands.open(path)
        run_until(session, lambda: session.editing.shot.source == path, "another source")
        assert session.facts.lens.focal_length_mm != 35.0
    finally:
        session.close()


def test_camera_is_ignored_with_an_impossible_command_line_lens(tmp_path):
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n1001,35,4,3\n1010,35,4,5\n")
    lens = {"focal_length_mm": 6000.0}
    source, camera = str(room_file(tmp_path / "a.exr", 8, 6)), read_camera(str(table))
    session = session_of(tmp_path, source=source, camera=camera, lens=lens)
    run_until_settled(session)
    try:
        assert session.facts.lens.focal_length_mm == 85.0 and not session.editing.shot.key_frames
        assert "6000" in session.messages.text
    finally:
        session.close()


def test_still_takes_the_frames_of_the_command_line_camera(tmp_path):
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n41,35,4,3\n50,35,4,5\n")
    still = room_file(tmp_path / "still.exr", 8, 6)
    session = session_of(tmp_path, source=str(still), camera=read_camera(str(table)))
    run_until_settled(session)
    try:
        assert session.editing.frame == 41 and session.editing.shot.frames.count == 10
    finally:
        session.close()


def test_impossible_command_line_lens_is_ignored_and_reported(tmp_path):
    lens = {"focal_length_mm": 3000.0, "focus_distance_m": 1.0}
    session = session_of(tmp_path, source=str(room_file(tmp_path / "a.exr", 8, 6)), lens=lens)
    run_until_settled(session)
    try:
        assert session.facts.lens.focal_length_mm == 85.0  # that of the header
        assert "3000" in session.messages.text
    finally:
        session.close()


def test_command_line_kit_limits_the_first_lens(tmp_path):
    kit = next(iter(kit_shelf().kits.values()))
    session = session_of(tmp_path, source=str(room_file(tmp_path / "a.exr", 8, 6)), kit=kit)
    run_until_settled(session)
    try:
        assert session.editing.shot.kit == kit
        mounted = session.lens.commands.kits.mounted_lens
        assert session.facts.lens.focal_length_mm == mounted.length_near(85.0)
        assert session.facts.lens.f_stop >= mounted.f_stop
    finally:
        session.close()


def test_command_line_plate_options_override_remembered_ones(tmp_path):
    still = str(room_file(tmp_path / "a.exr", 8, 6))
    preferences = Preferences.load(tmp_path / "preferences")
    preferences.remember_options(tmp_path, PlateOptions(scene_unit_m=0.5))
    renderer = FakeRenderer()
    for given_options, expected in (
        (PlateOptions(), PlateOptions(scene_unit_m=0.5)),
        (PlateOptions(scene_unit_m=2.0), PlateOptions(scene_unit_m=2.0)),
        (PlateOptions(sensor_width_mm=20.0), PlateOptions(scene_unit_m=0.5, sensor_width_mm=20.0)),
    ):
        session = Session(
            renderer, Start(still, plate_options=given_options), preferences=preferences
        )
        session.begin()
        run_until_settled(session)
        assert session.source.opened.options == expected
        session.close()


# Faults, and what is drawn


def test_show_error_autosaves_the_shot_for_a_fault_only(session, tmp_path):
    session.editing.edit(replace(session.editing.shot, looks=(Look("A", session.facts.lens),)))
    session.show_error(InputError("a file"))
    autosave = autosave_path(unnamed_path(tmp_path / "preferences", session.editing.shot.source))
    assert not autosave.exists() and session.messages.text == "a file"
    session.show_error(FaultError("a fault"))
    assert read_shot(autosave).looks[0].name == "A" and session.messages.text == "a fault"


def test_drawn_passes_the_shown_lens_to_the_ring(session):
    shown_lenses = []
    session.lens.ring.note_shown_lens = shown_lenses.append
    session.note_drawn()
    assert shown_lenses == [
        session.facts.shown_picture.shot.lens_at(session.facts.shown_picture.frame)
    ]


def test_session_facts_agree_with_the_parts_of_the_session(session):
    facts, pictures = session.facts, session.pictures
    assert facts.seen_shot == session.editing.seen_shot and facts.unit == "m" and facts.has_lens
    assert (
        facts.plate is session.source.plate and facts.histogram is session.source.picture.histogram
    )
    assert facts.reference is None is facts.stream and facts.opening == ""
    assert facts.is_live_alone and not facts.plays_cached_frames and not facts.has_camera
    assert (facts.shape.width_px, facts.shape.height_px) == (48, 32)
    data, display = facts.windows()
    assert data == display == facts.plate.display_window
    assert facts.frame_px(LEFT) == LEFT == facts.plate_px(LEFT)
    assert facts.picture_point((3.5, 4.5)) == (3.5, 4.5)
    pictures.commands.toggle_compare(Compare.WIPE)
    assert not session.facts.is_live_alone
    session.files.commands.open("not_there.exr")
    assert session.facts.opening == "not_there.exr" and facts.opening == "" and facts.is_live_alone


def test_remember_saves_view_preferences_but_not_the_desqueeze(session, tmp_path):
    view = session.pictures.commands
    view.toggle_unit()
    view.toggle_guide("thirds")
    view.change(guides=replace(session.facts.view.guides, desqueeze=2.0))
    session.time.timeline.playback.is_every_frame = not session.preferences.values.every_frame
    session.save_preferences()
    run_until_settled(session)
    remembered = Preferences.load(tmp_path / "preferences").values
    assert (
        remembered.unit == "ft" and remembered.guides.thirds and remembered.guides.desqueeze is None
    )
    assert remembered.every_frame is session.time.timeline.playback.is_every_frame


def test_session_wants_frames_only_after_an_edit(session):
    run_until_settled(session)
    session.messages.clear()
    assert not session.wants_frames
    session.editing.edit(replace(session.editing.shot, looks=(Look("A", session.facts.lens),)))
    assert session.wants_frames and session.seconds_until_needed() <= 0.1
    session.messages.notify("A word.")
    assert session.seconds_until_needed() is not None


# Lessons


def test_lessons_drop_each_gesture_once_it_is_done():
    editing = Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0), source=DEMO), lambda _text: None)
    marks = SimpleNamespace(pulls=SimpleNamespace(pull_count=3))
    lessons = Lessons(editing, marks)
    lessons.watch(is_dragging=True, is_pressed=True)
    assert lessons.remaining == tuple(Lesson)

    def focus(distance_m):
        editing.edit_lens(replace(editing.lens, focus_distance_m=distance_m))

    focus(3.0)
    lessons.watch(is_dragging=False, is_pressed=False)  # by a key
    assert lessons.remaining == tuple(Lesson)
    focus(4.0)
    lessons.watch(is_dragging=False, is_pressed=True)
    assert lessons.remaining == (Lesson.DRAG, Lesson.PULL)
    editing.frame = 7
    focus(5.0)
    lessons.watch(is_dragging=True, is_pressed=False)  # another frame has its own focus
    assert Lesson.DRAG in lessons.remaining
    focus(6.0)
    lessons.watch(is_dragging=True, is_pressed=True)
    assert lessons.remaining == (Lesson.PULL,)
    marks.pulls.pull_count = 4
    lessons.watch(is_dragging=False, is_pressed=False)
    assert lessons.remaining == ()
    next_lessons = Lessons(editing, marks)
    assert next_lessons.remaining == tuple(Lesson)
    next_lessons.is_dismissed = True
    assert next_lessons.remaining == ()
    own_editing = Editing(Shot(Lens(50.0, 2.8, 2.0, 36.0), source="mine.exr"), lambda _text: None)
    assert Lessons(own_editing, marks).remaining == ()


# Stretching by hand


def test_key_stretch_drags_either_end_of_the_chosen_keys():
    messages = []
    editing = Editing(KEYED.with_key(30, FOCUS, 6.0), messages.append)
    keys = KeyCommands(shared_of(editing, messages.append), RowChoice(lambda: False), lambda: None)
    stretch = KeyStretch(editing, keys, messages.append)
    stretch.press(is_last=True)
    stretch.drag(25)
    assert stretch.ends is None and editing.shot == KEYED.with_key(30, FOCUS, 6.0)
    keys.select_between(FOCUS, 10, 20)
    assert stretch.ends == Ends(10, 20)
    stretch.press(is_last=True)
    stretch.drag(40)
    assert [key.frame for key in editing.shot.curves.of(FOCUS).keys] == [10, 30, 40] or (
        stretch.ends == Ends(10, 40)
    )
    stretch.drag(2)
    assert stretch.ends == Ends(10, 11)
    stretch.drag(30)
    stretch.release()
    assert "gave way" in messages[-1] and stretch.ends == Ends(10, 30)
    editing.undo()
    assert len(all_keys(editing.shot)) == 3
    keys.select_between(FOCUS, 10, 20)
    stretch.press(is_last=False)
    stretch.drag(25)
    assert stretch.ends == Ends(19, 20)
    stretch.drag(4)
    stretch.release()
    assert stretch.ends == Ends(4, 20) and not editing.is_unsettled


# Comparison and colour


def test_compare_sides_render_b_by_another_method_or_look(ctx, renderer, tmp_path):
    path = str(room_file(tmp_path / "room.exr", 32, 24))
    session = session_of(tmp_path, renderer, source=path, defocus=QUICK)
    run_until_settled(session)
    try:
        sides, view = session.pictures.sides, session.pictures.commands
        view.compare_with(Method.GATHER)
        run_until(session, lambda: sides.picture_of_b(session.facts.view) is not None, "B")
        run_until_settled(session)
        shot = session.editing.shot
        gathered = replace(shot, defocus=replace(shot.defocus, method=Method.GATHER))
        pixels = download(sides.picture_of_b(session.facts.view).texture)
        np.testing.assert_allclose(pixels, renderer.pixels(gathered), atol=2e-3, rtol=2e-3)
        view.compare_with(Method.RAYTRACED)  # which needs a scene
        assert sides.picture_of_b(session.facts.view) is None
        wide = replace(session.facts.lens, f_stop=8.0)
        session.editing.do(replace(shot, looks=(Look("A", session.facts.lens), Look("B", wide))))
        session.pictures.looks.compare(session.editing.shot.looks[1])
        run_until(session, lambda: sides.picture_of_b(session.facts.view) is not None, "the look")
        run_until_settled(session)
        assert not sides.is_unfinished("B")
        session.pictures.looks.compare_as_a(session.editing.shot.looks[0])
        run_loop_once(session)
        assert sides.picture_of_a(session.facts.view) is sides.a.output  # it is the lens as it is
        assert not sides.is_unfinished("A")
        view.change(against=Against.PINHOLE)
        run_loop_once(session)
        assert sides.picture_of_a(session.facts.view) is None and sides.active_sides == (sides.a,)
    finally:
        session.close()


def test_grid_draws_looks_of_a_scene_with_their_own_field_of_view(ctx, renderer, tmp_path):
    path = str(write_scene(tmp_path / "scene.glb"))
    session = session_of(tmp_path, renderer, source=path, defocus=QUICK)
    run_until(session, lambda: session.source.opened is not None, "the scene")
    small = replace(session.editing.shot.framing, width_px=32, height_px=20)
    shot = replace(session.editing.shot, framing=small)
    long_lens = replace(shot.lens, focal_length_mm=2 * shot.lens.focal_length_mm)
    wide_lens = replace(shot.lens, focal_length_mm=0.7 * shot.lens.focal_length_mm)
    session.editing.begin(replace(shot, looks=(Look("A", long_lens), Look("B", wide_lens))))
    try:
        session.pictures.looks.toggle_grid()
        looks: LookPictures = session.pictures.sides.looks
        run_loop_once(session)
        quick = looks._tiles["A"].quick_key
        assert quick.shot.framing.size == (8, 5) and quick.settings == fastest_settings(QUICK)
        run_until(
            session, lambda: None not in (looks.picture_of("A"), looks.picture_of("B")), "both"
        )
        run_until(
            session,
            lambda: not (looks.is_unfinished("A") or looks.is_unfinished("B")),
            "both, whole",
        )
        run_until_settled(session)
        for look in session.editing.shot.looks:
            shown = looks.picture_of(look.name)
            assert shown.texture.size == (32, 20)
            through = session.editing.shot.with_look(look)
            expected = renderer.pixels(through, session.editing.frame)
            assert np.abs(download(shown.texture) - expected).mean() < 0.01
        session.pictures.looks.toggle_grid()
        run_loop_once(session)
        assert looks.output == () and not looks.is_working
    finally:
        session.close()


def test_color_transform_changes_only_with_the_names_of_the_view(ctx, session):
    color, screen = session.pictures.color, ScreenPictures(ctx)
    view = color.limit_to_config(session.facts.view)
    color.apply(view, screen)
    assert screen.transform_version == 1
    transform = color.transform
    color.apply(view, screen)
    assert screen.transform_version == 1 and color.transform is transform
    (*_, other_view) = load_color_config(None).views(view.display)
    color.apply(replace(view, view=other_view), screen)
    assert screen.transform_version == 2 and color.transform is not transform
    color.rebuild()
    color.apply(replace(view, view=other_view), screen)
    assert screen.transform_version == 3
    transform = color.transform
    color.apply(replace(view, view="no such view"), screen)
    assert session.messages.text and color.transform is transform  # the last good one stays


def test_display_options_for_files_follow_exposure_gamma_and_t_stop(session, ctx):
    view = session.pictures.commands
    view.expose(4)
    view.change(gamma=2.0)
    display = session.files.exports._display
    options = display.options()
    assert options.exposure_stops == 1.0 and options.gamma == 2.0
    assert options.display == session.facts.view.display and options.view == session.facts.view.view
    session.editing.edit_lens(
        replace(session.facts.lens, t_stop=session.facts.lens.f_stop * math.sqrt(2))
    )
    assert display.options().exposure_stops == pytest.approx(0.0)
    light = np.full((2, 2, 3), 0.18, np.float32)
    brighter = display.values(ctx).encode(light)
    view.expose(-4)
    assert (display.values(ctx).encode(light) < brighter).all()


def test_interpolate_applies_to_all_chosen_keys_of_a_pull(session):
    session.time.marks.set_point(LEFT)
    session.time.marks.set_point(RIGHT)
    assert isinstance(session.editing.shot.marks[0], PointMark)
    session.time.marks.pulls.set_length(LAST - FIRST)
    session.time.marks.pulls.make()
    run_until(session, lambda: not session.time.marks.distances.has_request, "the pull")
    session.time.keys.select_all()
    session.time.keys.interpolate(Interpolation.LINEAR)
    keys = session.editing.shot.curves.of(FOCUS).keys
    assert {key.interpolation for key in keys} == {Interpolation.LINEAR}
