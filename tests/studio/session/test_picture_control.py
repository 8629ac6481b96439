"""How a picture is viewed, measured and compared, without a window."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError, HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, Method, Quality
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.core.model.view.view_geometry import Intrinsics, PictureShape, Viewport
from heatlens.media.plate.read import read_plate
from heatlens.render.display.color_choice import ColorChoice
from heatlens.render.gpu.textures import download
from heatlens.render.preview.speed import Speed
from heatlens.studio.session.opened.gpu_picture import GpuPicture
from heatlens.studio.session.pictures.view_commands import ReferenceLoader
from support.evening import FIRST, HEIGHT, LEFT, RIGHT, WIDTH, begin_session, run_until_settled
from support.exr_files import write_file
from support.plates import coc_plate_of, plate_of
from support.session_files import room_file
from support.shared import shared_of
from support.tev_peers import wait_until

LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture
def view(session):
    return session.pictures.commands


# The ruler


def test_point_m_places_pixel_as_seen_by_a_pinhole_camera():
    camera = Intrinsics(focal_length_mm=50.0, sensor_width_mm=36.0, shape=PictureShape(36, 24))
    # One pixel is 1 mm of the sensor: at 50 m a metre.
    assert camera.point_m((18, 12), 50.0) == pytest.approx((0.5, 0.5, 50.0))
    assert camera.point_m((0, 0), 50.0) == pytest.approx((-17.5, -11.5, 50.0))
    wide = Intrinsics(50.0, 36.0, PictureShape(36, 24, pixel_aspect=2.0))
    assert wide.point_m((19, 11), 50.0) == pytest.approx((1.5, -0.25, 50.0))


def test_ruler_measures_distance_in_space_between_two_presses(session, view):
    ruler = view.ruler
    view.toggle_ruler()
    assert ruler.is_on and ruler.why_not() == "" and not session.messages.text
    ruler.press(LEFT)
    assert ruler.points == (LEFT,) and ruler.measure() is None
    across = (RIGHT[0] - LEFT[0], 0)
    pitch = 36.0 / WIDTH / 50.0
    x0, x1 = ((pixel[0] + 0.5 - WIDTH / 2) * pitch for pixel in (LEFT, RIGHT))
    expected_m = math.dist((2 * x0, 0.0, 2.0), (8 * x1, 0.0, 8.0))
    for measurement in (ruler.measure(RIGHT), ruler.press(RIGHT) or ruler.measure()):
        assert measurement.depths_m == (2.0, 8.0)
        assert measurement.distance_m == pytest.approx(expected_m, rel=1e-2)
    assert across and ruler.measure(LEFT) == ruler.measure()  # two points are enough
    ruler.press((20, 20))
    assert ruler.points == ((20, 20),)
    ruler.drag((20, 20))
    assert ruler.points == ((20, 20),)
    ruler.drag((21, 20))
    ruler.drag((22, 20))
    assert ruler.points == ((20, 20), (22, 20))
    ruler.drag((9999, 20))
    ruler.press((9999, 20))
    assert ruler.points == ((20, 20), (22, 20)) and ruler.measure((9999, 20)) is not None
    view.toggle_ruler()
    assert not ruler.is_on and ruler.points == ()
    assert not view.leave_mode()


def test_leave_closes_the_ruler_before_the_grid(session, view):
    view.toggle_compare(Compare.GRID)
    view.toggle_ruler()
    assert session.facts.view.compare is Compare.OFF and view.ruler.is_on
    view.change(compare=Compare.GRID)
    assert view.leave_mode() and not view.ruler.is_on and session.facts.view.compare is Compare.GRID
    assert view.leave_mode() and session.facts.view.compare is Compare.OFF
    view.toggle_compare(Compare.WIPE)
    assert not view.leave_mode() and session.facts.view.compare is Compare.WIPE


def test_ruler_says_why_it_cannot_measure(session, view):
    ruler, picture = view.ruler, session.source.picture
    grey = np.ones((4, 6, 3), np.float32)
    picture.plate = coc_plate_of(grey, np.ones((4, 6), np.float32))
    assert "distances" in ruler.why_not() and not ruler.is_inside((2, 2))
    sky = np.full((4, 6), np.inf, np.float32)
    sky[:, :3] = 2.0
    picture.plate = plate_of(grey, sky)
    ruler.points = ((1, 1), (4, 1))
    assert ruler.measure() is None or math.isinf(ruler.measure().distance_m)
    ruler.switch_off()
    ruler.toggle()
    assert "lens" in session.messages.text
    picture.plate = None
    assert "distances" not in ruler.why_not() != "" and ruler.measure((1, 1)) is None
    assert not ruler.is_inside((1, 1))


# The view


def test_expose_steps_by_quarter_stops_and_reset_restores(session, view):
    view.expose(3)
    assert session.facts.view.exposure_stops == 0.75
    view.expose(-1)
    view.change(gamma=2.0)
    assert session.facts.view.exposure_stops == 0.5
    view.reset_exposure_and_gamma()
    assert (session.facts.view.exposure_stops, session.facts.view.gamma) == (0.0, 1.0)


def test_unit_matte_guide_and_peaking_toggle(session, view):
    for unit in ("ft", "m"):
        view.toggle_unit()
        assert session.facts.view.unit == unit
    for aspect, shown in ((2.39, 2.39), (1.85, 1.85), (1.85, None)):
        view.toggle_matte(aspect)
        assert session.facts.view.guides.aspect == shown
    for is_on in (True, False):
        view.toggle_guide("thirds")
        view.toggle("is_peaking")
        assert session.facts.view.guides.thirds is is_on is session.facts.view.is_peaking


def test_zoom_keeps_the_middle_and_one_to_one_is_zoom_one(session, view):
    session.pictures.view.viewport = Viewport((0.0, 0.0), (96.0, 64.0))
    view.one_to_one()
    assert session.facts.view.zoom == 1.0
    view.zoom(2.0)
    assert session.facts.view.zoom == 2.0
    assert session.facts.view.center_px == pytest.approx((WIDTH / 2, HEIGHT / 2))
    view.fit()
    assert session.facts.view.zoom is None is session.facts.view.center_px


def test_b_can_be_pinhole_method_or_loaded_reference(session, view):
    view.compare_with(Method.SCATTER)
    state = session.facts.view
    assert (state.compare, state.against, state.b_method) == (
        *(Compare.WIPE, Against.METHOD, Method.SCATTER),
    )
    view.change(compare=Compare.FLIP)
    view.compare_with(None)
    assert (session.facts.view.compare, session.facts.view.against) == (
        Compare.FLIP,
        Against.PINHOLE,
    )
    view.swap_b()
    assert session.facts.view.against is Against.PINHOLE and "No reference" in session.messages.text
    session.pictures.references.current = object()
    view.swap_b()
    assert session.facts.view.against is Against.REFERENCE
    view.swap_b()
    assert session.facts.view.against is Against.PINHOLE
    session.pictures.references.current = None


def test_reference_loader_keeps_last_reference_when_reading_fails(ctx, tmp_path):
    messages = []
    picture = SimpleNamespace(renderer=SimpleNamespace(ctx=ctx))
    source = SimpleNamespace(picture=picture)
    loader = ReferenceLoader(shared_of(None, messages.append, source))
    loader.poll()
    assert loader.current is None
    path = room_file(tmp_path / "r.exr", 8, 6)
    loader.open(path)
    wait_until(lambda: loader.poll() or loader.current is not None)
    first_reference = loader.current
    assert (
        first_reference.path == path
        and messages == ["B is r.exr."]
        and first_reference.texture.size == (8, 6)
    )
    np.testing.assert_allclose(download(first_reference.texture), read_plate(path).color, rtol=1e-3)
    (tmp_path / "bad.exr").write_bytes(b"damaged")
    loader.open(tmp_path / "bad.exr")
    with pytest.raises(HeatlensError, match=r"bad\.exr"):
        wait_until(lambda: loader.poll() or False)
    assert loader.current is first_reference
    loader.open(room_file(tmp_path / "s.exr", 9, 6))
    wait_until(lambda: loader.poll() or loader.current is not first_reference)
    assert loader.current.texture.size == (9, 6)
    loader.current.texture.release()


# The lens, the time of the window, the picture on the GPU


def test_lens_commands_nudge_reset_and_cycle_values(session):
    lens = session.lens.commands
    start = session.facts.lens
    most = session.source.picture.histogram.most_dioptres
    lens.nudge_focus(10.0)
    assert 1 / session.facts.lens.focus_distance_m == pytest.approx(0.25 + 10 / 250 * most)
    lens.nudge_focus(-1000.0)
    assert math.isinf(session.facts.lens.focus_distance_m)
    lens.reset()
    assert session.facts.lens == start
    lens.focus_at_infinity()
    assert math.isinf(session.facts.lens.focus_distance_m)
    lens.focus_at((9999, 5))
    assert math.isinf(session.facts.lens.focus_distance_m)
    for values, command, field in (
        (list(Bokeh), lens.next_bokeh, "bokeh"),
        ([None, *Quality], lens.next_quality, "quality"),
    ):
        before = getattr(session.editing.shot.defocus, field)
        chosen_values = []
        for _ in values:
            command()
            chosen_values.append(getattr(session.editing.shot.defocus, field))
        assert set(chosen_values) == set(values) and chosen_values[-1] is before


def test_speed_gives_the_picture_the_rest_of_a_frame():
    gpu = Speed()
    assert gpu.budget_s == 0.012 and gpu.mean_ms() is None is gpu.pictures_per_second()
    assert math.isinf(gpu.answer_s)
    gpu.has_window = True
    assert gpu.answer_s == 2 * 0.012
    slow = Speed(is_software=True)
    assert slow.budget_s == pytest.approx(0.068 - 0.02)
    slow.is_for_ring = True
    assert slow.budget_s == pytest.approx(0.04 - 0.02)
    slow.note_frame(0.1, 0.05, is_dragging=False)
    assert slow.window_s == pytest.approx(0.02 + 0.2 * (0.05 - 0.02))
    slow.window_s, slow.has_window = 0.08, True
    assert slow.answer_s == pytest.approx(2 * 0.08)  # another frame of the window would take longer
    slow.window_s = 1.0
    assert slow.budget_s == 0.012 and slow.answer_s == 0.2
    slow.note_frame(0.3, 0.0, is_dragging=True)
    assert slow.mean_ms() == pytest.approx(200.0) and slow.pictures_per_second() is None
    slow.note_frame(0.2, 0.1, is_dragging=True)
    assert slow.pictures_per_second() == pytest.approx(5.0)
    for _ in range(40):
        slow.note_frame(0.1, 0.0, is_dragging=False)
    assert len(slow.frames_s) == 30


def test_gpu_picture_keeps_version_axis_and_problem_of_its_frame(renderer):
    picture = GpuPicture(renderer)
    assert not (picture.is_finer or picture.is_black or picture.is_settled) and not picture.version
    grey, depth = np.ones((4, 6, 3), np.float32), np.full((4, 6), 2.0, np.float32)
    picture.mark_changed()
    assert picture.version == 0  # there is none yet
    picture.load(plate_of(grey, depth))
    assert picture.version == 1 and picture.histogram is not None and picture.upload_s > 0
    axis = picture.histogram.most_dioptres
    picture.extend_axis(0.1)
    longer = picture.histogram.most_dioptres
    assert longer > axis
    picture.extend_axis(1.0)
    assert picture.histogram.most_dioptres == longer  # never shorter
    picture.reset_axis()
    picture.load(plate_of(grey, depth))
    assert picture.histogram.most_dioptres == axis
    picture.mark_changed()
    assert picture.version == 3
    plate = picture.plate
    with picture.draw_safely():
        raise InputError("no lens")
    assert picture.problem == "no lens" and picture.plate is plate
    with picture.draw_safely():
        renderer.load(plate_of(grey, depth))
    assert picture.plate is renderer.loaded.plate is not plate and picture.version == 4
    with picture.draw_safely():
        raise GpuError("no memory")
    assert picture.plate is None and picture.problem == "no memory"
    picture.request(7)
    assert (picture.problem, picture.frame, picture.is_black) == ("", 7, False)
    picture.load(coc_plate_of(grey, depth))
    assert picture.histogram is None


def test_limit_to_config_replaces_names_unknown_to_the_color_config():
    messages = []
    color = ColorChoice(None, messages.append)
    assert color.displays() and color.input_spaces() is not None and not messages
    view = color.limit_to_config(
        ViewState(display="no display", view="no view", input_space="none")
    )
    assert view.display in color.displays() and view.view in color.views(view.display)
    assert view.input_space == "" and view.view == color.usual_view(view.display)
    assert color.limit_to_config(view) == view and color.chosen_view(view) == ""
    (*_, other_view) = color.views(view.display)
    chosen = replace(view, view=other_view)
    assert color.limit_to_config(chosen) == chosen and color.chosen_view(chosen) == other_view
    assert color.adapt_to_plate(chosen, {}) == chosen  # a chosen one stays
    with pytest.raises(HeatlensError):
        ColorChoice("/no/such/config.ocio", messages.append)


def test_session_opens_at_the_first_frame_of_the_sequence(session):
    assert session.editing.frame == FIRST


def test_focus_at_takes_blurred_foreground_and_focus_on_other_toggles(tmp_path):
    depth, color = np.full((60, 360), 3.0, np.float32), np.full((60, 360), 0.5, np.float32)
    depth[:, np.arange(360) % 8 >= 3] = 0.9
    write_file(tmp_path / "twigs.exr", dict.fromkeys("RGB", color) | {"Z": depth})
    session = begin_session(tmp_path / "preferences", str(tmp_path / "twigs.exr"))
    run_until_settled(session)
    lens, editing, hole = session.lens.commands, session.editing, (41, 30)
    editing.edit_lens(Lens(50.0, 1.4, 3.0, 36.0))
    editing.settle()
    lens.focus_at(hole)
    assert session.facts.lens.focus_distance_m == pytest.approx(0.9)
    assert "0.9 m" in session.messages.text and "3 m" in session.messages.text
    lens.focus_at(hole)  # the button is still down
    assert session.facts.lens.focus_distance_m == pytest.approx(0.9)
    lens.focus_on_other()
    assert session.facts.lens.focus_distance_m == pytest.approx(3.0)
    lens.focus_on_other()
    assert session.facts.lens.focus_distance_m == pytest.approx(0.9)
    editing.undo()
    session.time.marks.set_point(hole)
    assert session.time.marks.distances.distance_m(editing.shot.marks[-1]) == pytest.approx(0.9)
    editing.edit_lens(Lens(50.0, 16.0, 3.0, 36.0))
    lens.focus_on_other()
    assert "no other" in session.messages.text
    session.close()
