"""How a picture is looked at, measured and compared, without a window."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import GpuError, HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import Bokeh, Method, Quality
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.core.model.view.view_geometry import PictureShape, Viewport
from heatlens.media.plate.read import read_plate
from heatlens.render.gpu.textures import download
from heatlens.studio.session.opened.gpu_picture import GpuPicture
from heatlens.studio.session.pictures.picture_view import ColorChoice
from heatlens.studio.session.pictures.ruler import Intrinsics
from heatlens.studio.session.pictures.view_commands import ReferenceLoader
from heatlens.studio.session.speed import Speed
from support.evening import FIRST, HEIGHT, LEFT, RIGHT, WIDTH, begun, settled
from support.exr_files import write_file
from support.plates import coc_plate_of, plate_of
from support.session_files import room_file
from support.shared import shared_of
from support.tev_peers import wait_until

LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture
def view(walls):
    return walls.pictures.commands


# The ruler


def test_a_pixel_lies_where_a_pinhole_camera_sees_it():
    camera = Intrinsics(50.0, 36.0, PictureShape(36, 24))
    # One pixel is 1 mm of the sensor: at 50 m a metre.
    assert camera.point_m((18, 12), 50.0) == pytest.approx((0.5, 0.5, 50.0))
    assert camera.point_m((0, 0), 50.0) == pytest.approx((-17.5, -11.5, 50.0))
    wide = Intrinsics(50.0, 36.0, PictureShape(36, 24, pixel_aspect=2.0))
    assert wide.point_m((19, 11), 50.0) == pytest.approx((1.5, -0.25, 50.0))


def test_two_presses_measure_the_distance_in_space(walls, view):
    ruler = view.ruler
    view.toggle_ruler()
    assert ruler.is_on and ruler.why_not() == "" and not walls.messages.text
    ruler.press(LEFT)
    assert ruler.points == (LEFT,) and ruler.measured() is None
    across = (RIGHT[0] - LEFT[0], 0)
    pitch = 36.0 / WIDTH / 50.0
    x0, x1 = ((at[0] + 0.5 - WIDTH / 2) * pitch for at in (LEFT, RIGHT))
    wanted = math.dist((2 * x0, 0.0, 2.0), (8 * x1, 0.0, 8.0))
    for measured in (ruler.measured(RIGHT), ruler.press(RIGHT) or ruler.measured()):
        assert measured.depths_m == (2.0, 8.0)
        assert measured.distance_m == pytest.approx(wanted, rel=1e-2)
    assert across and ruler.measured(LEFT) == ruler.measured()  # two points are enough
    ruler.press((20, 20))
    assert ruler.points == ((20, 20),)
    ruler.drag((20, 20))
    assert ruler.points == ((20, 20),)
    ruler.drag((21, 20))
    ruler.drag((22, 20))
    assert ruler.points == ((20, 20), (22, 20))
    ruler.drag((9999, 20))
    ruler.press((9999, 20))
    assert ruler.points == ((20, 20), (22, 20)) and ruler.measured((9999, 20)) is not None
    view.toggle_ruler()
    assert not ruler.is_on and ruler.points == ()
    assert not view.leave()


def test_escape_leaves_the_ruler_before_the_grid(walls, view):
    view.toggle_compare(Compare.GRID)
    view.toggle_ruler()
    assert walls.facts.view.compare is Compare.OFF and view.ruler.is_on
    view.change(compare=Compare.GRID)
    assert view.leave() and not view.ruler.is_on and walls.facts.view.compare is Compare.GRID
    assert view.leave() and walls.facts.view.compare is Compare.OFF
    view.toggle_compare(Compare.WIPE)
    assert not view.leave() and walls.facts.view.compare is Compare.WIPE


def test_what_cannot_be_measured_says_why(walls, view):
    ruler, picture = view.ruler, walls.source.picture
    grey = np.ones((4, 6, 3), np.float32)
    picture.plate = coc_plate_of(grey, np.ones((4, 6), np.float32))
    assert "distances" in ruler.why_not() and not ruler.is_inside((2, 2))
    sky = np.full((4, 6), np.inf, np.float32)
    sky[:, :3] = 2.0
    picture.plate = plate_of(grey, sky)
    ruler.points = ((1, 1), (4, 1))
    assert ruler.measured() is None or math.isinf(ruler.measured().distance_m)
    ruler.leave()
    ruler.toggle()
    assert "lens" in walls.messages.text
    picture.plate = None
    assert "distances" not in ruler.why_not() != "" and ruler.measured((1, 1)) is None
    assert not ruler.is_inside((1, 1))


# The view


def test_exposure_goes_in_quarter_stops_and_comes_back(walls, view):
    view.expose(3)
    assert walls.facts.view.exposure_stops == 0.75
    view.expose(-1)
    view.change(gamma=2.0)
    assert walls.facts.view.exposure_stops == 0.5
    view.reset_exposure_and_gamma()
    assert (walls.facts.view.exposure_stops, walls.facts.view.gamma) == (0.0, 1.0)


def test_units_guides_and_switches_toggle(walls, view):
    for unit in ("ft", "m"):
        view.toggle_unit()
        assert walls.facts.view.unit == unit
    for aspect, shown in ((2.39, 2.39), (1.85, 1.85), (1.85, None)):
        view.toggle_matte(aspect)
        assert walls.facts.view.guides.aspect == shown
    for is_on in (True, False):
        view.toggle_guide("thirds")
        view.toggle("is_peaking")
        assert walls.facts.view.guides.thirds is is_on is walls.facts.view.is_peaking


def test_zoom_is_about_the_middle_and_one_to_one_is_one_pixel(walls, view):
    walls.pictures.view.viewport = Viewport((0.0, 0.0), (96.0, 64.0))
    view.one_to_one()
    assert walls.facts.view.zoom == 1.0
    view.zoom(2.0)
    assert walls.facts.view.zoom == 2.0
    assert walls.facts.view.center_px == pytest.approx((WIDTH / 2, HEIGHT / 2))
    view.fit()
    assert walls.facts.view.zoom is None is walls.facts.view.center_px


def test_b_is_the_pinhole_a_method_or_a_reference(walls, view):
    view.compare_with(Method.SCATTER)
    state = walls.facts.view
    assert (state.compare, state.against, state.b_method) == (
        *(Compare.WIPE, Against.METHOD, Method.SCATTER),
    )
    view.change(compare=Compare.FLIP)
    view.compare_with(None)
    assert (walls.facts.view.compare, walls.facts.view.against) == (Compare.FLIP, Against.PINHOLE)
    view.swap_b()
    assert walls.facts.view.against is Against.PINHOLE and "No reference" in walls.messages.text
    walls.pictures.references.current = object()
    view.swap_b()
    assert walls.facts.view.against is Against.REFERENCE
    view.swap_b()
    assert walls.facts.view.against is Against.PINHOLE
    walls.pictures.references.current = None


def test_a_reference_is_read_and_the_one_before_stays_where_it_fails(ctx, tmp_path):
    said = []
    picture = SimpleNamespace(renderer=SimpleNamespace(ctx=ctx))
    source = SimpleNamespace(picture=picture)
    loader = ReferenceLoader(shared_of(None, said.append, source))
    loader.poll()
    assert loader.current is None
    path = room_file(tmp_path / "r.exr", 8, 6)
    loader.open(path)
    wait_until(lambda: loader.poll() or loader.current is not None)
    found = loader.current
    assert found.path == path and said == ["B is r.exr."] and found.texture.size == (8, 6)
    np.testing.assert_allclose(download(found.texture), read_plate(path).color, rtol=1e-3)
    (tmp_path / "bad.exr").write_bytes(b"damaged")
    loader.open(tmp_path / "bad.exr")
    with pytest.raises(HeatlensError, match=r"bad\.exr"):
        wait_until(lambda: loader.poll() or False)
    assert loader.current is found
    loader.open(room_file(tmp_path / "s.exr", 9, 6))
    wait_until(lambda: loader.poll() or loader.current is not found)
    assert loader.current.texture.size == (9, 6)
    loader.current.texture.release()


# The lens, the time of the window, the picture on the GPU


def test_focus_is_nudged_by_a_share_of_the_bar_and_reset(walls):
    lens = walls.lens.commands
    start = walls.facts.lens
    most = walls.source.picture.histogram.most_dioptres
    lens.nudge_focus(10.0)
    assert 1 / walls.facts.lens.focus_distance_m == pytest.approx(0.25 + 10 / 250 * most)
    lens.nudge_focus(-1000.0)
    assert math.isinf(walls.facts.lens.focus_distance_m)
    lens.reset()
    assert walls.facts.lens == start
    lens.focus_at_infinity()
    assert math.isinf(walls.facts.lens.focus_distance_m)
    lens.focus_at((9999, 5))
    assert math.isinf(walls.facts.lens.focus_distance_m)
    for values, command, field in (
        (list(Bokeh), lens.next_bokeh, "bokeh"),
        ([None, *Quality], lens.next_quality, "quality"),
    ):
        before = getattr(walls.editing.shot.defocus, field)
        seen = []
        for _ in values:
            command()
            seen.append(getattr(walls.editing.shot.defocus, field))
        assert set(seen) == set(values) and seen[-1] is before


def test_what_is_left_of_a_frame_is_for_the_picture():
    gpu = Speed()
    assert gpu.budget_s == 0.012 and gpu.mean_ms() is None is gpu.pictures_per_second()
    assert math.isinf(gpu.answer_s)
    gpu.has_window = True
    assert gpu.answer_s == 2 * 0.012
    slow = Speed(is_software=True)
    assert slow.budget_s == pytest.approx(0.068 - 0.02)
    slow.is_for_ring = True
    assert slow.budget_s == pytest.approx(0.04 - 0.02)
    slow.frame(0.1, 0.05, is_held=False)
    assert slow.window_s == pytest.approx(0.02 + 0.2 * (0.05 - 0.02))
    slow.window_s = 1.0
    assert slow.budget_s == 0.012
    slow.frame(0.3, 0.0, is_held=True)
    assert slow.mean_ms() == pytest.approx(200.0) and slow.pictures_per_second() is None
    slow.frame(0.2, 0.1, is_held=True)
    assert slow.pictures_per_second() == pytest.approx(5.0)
    for _ in range(40):
        slow.frame(0.1, 0.0, is_held=False)
    assert len(slow.frames_s) == 30


def test_an_error_while_drawing_is_a_problem_of_the_frame(renderer):
    picture = GpuPicture(renderer)
    assert not (picture.is_finer or picture.is_black or picture.is_settled) and not picture.version
    grey, depth = np.ones((4, 6, 3), np.float32), np.full((4, 6), 2.0, np.float32)
    picture.count_again()
    assert picture.version == 0  # there is none yet
    picture.load(plate_of(grey, depth))
    assert picture.version == 1 and picture.histogram is not None and picture.upload_s > 0
    axis = picture.histogram.most_dioptres
    picture.reach(0.1)
    longer = picture.histogram.most_dioptres
    assert longer > axis
    picture.reach(1.0)
    assert picture.histogram.most_dioptres == longer  # never shorter
    picture.begin_axis()
    picture.load(plate_of(grey, depth))
    assert picture.histogram.most_dioptres == axis
    picture.count_again()
    assert picture.version == 3
    plate = picture.plate
    with picture.drawing():
        raise InputError("no lens")
    assert picture.problem == "no lens" and picture.plate is plate
    with picture.drawing():
        renderer.load(plate_of(grey, depth))
    assert picture.plate is renderer.loaded.plate is not plate and picture.version == 4
    with picture.drawing():
        raise GpuError("no memory")
    assert picture.plate is None and picture.problem == "no memory"
    picture.ask(7)
    assert (picture.problem, picture.frame, picture.is_black) == ("", 7, False)
    picture.load(coc_plate_of(grey, depth))
    assert picture.histogram is None


def test_a_view_keeps_names_that_the_config_has():
    said = []
    color = ColorChoice(None, said.append)
    assert color.displays() and color.input_spaces() is not None and not said
    view = color.with_names(ViewState(display="no display", view="no view", input_space="none"))
    assert view.display in color.displays() and view.view in color.views(view.display)
    assert view.input_space == "" and view.view == color.usual_view(view.display)
    assert color.with_names(view) == view and color.chosen_view(view) == ""
    (*_, other) = color.views(view.display)
    chosen = replace(view, view=other)
    assert color.with_names(chosen) == chosen and color.chosen_view(chosen) == other
    assert color.of_plate(chosen, {}) == chosen  # a chosen one stays
    with pytest.raises(HeatlensError):
        ColorChoice("/no/such/config.ocio", said.append)


def test_the_first_frame_is_where_the_walls_begin(walls):
    assert walls.editing.frame == FIRST


def test_a_click_takes_the_blurred_foreground_and_a_key_the_other(tmp_path):
    depth, color = np.full((60, 360), 3.0, np.float32), np.full((60, 360), 0.5, np.float32)
    depth[:, np.arange(360) % 8 >= 3] = 0.9
    write_file(tmp_path / "twigs.exr", dict.fromkeys("RGB", color) | {"Z": depth})
    session = begun(tmp_path / "preferences", str(tmp_path / "twigs.exr"))
    settled(session)
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
    assert session.time.marks.distances.of_m(editing.shot.marks[-1]) == pytest.approx(0.9)
    editing.edit_lens(Lens(50.0, 16.0, 3.0, 36.0))
    lens.focus_on_other()
    assert "no other" in session.messages.text
    session.close()
