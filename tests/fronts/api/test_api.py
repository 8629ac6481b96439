"""Test the Python interface: files and arrays give the same pictures as the command line."""

import subprocess
import sys
import threading

import numpy as np
import pytest

import heatlens
from heatlens.core.base.errors import HeatlensError
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.read import read_plate
from support.command_line import CAMERA, ENVIRONMENT, channels, picture
from support.exr_files import write_file

WORDS = ("--f-stop", "1.4", "--focus-distance", "3", "--float", "--quality", "draft")
LENS = {"f_stop": 1.4, "focus_distance_m": 3.0, "quality": "draft"}


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "p.exr", channels(), **CAMERA)


def render_by_command(tmp_path, *words: object) -> np.ndarray:
    """Return the picture that `heatlens render` writes."""
    out = tmp_path / "out.exr"
    assert main(["render", *map(str, words), "-o", str(out)]) == 0
    return picture(out)[1]


def test_render_of_plate_equals_render_command(plate, tmp_path):
    rendered = heatlens.open(plate).render(**LENS)
    assert (
        rendered.dtype == np.float32
        and rendered.shape == (10, 16, 4)
        and (rendered[..., 3] == 1).all()
    )
    np.testing.assert_array_equal(rendered[..., :3], render_by_command(tmp_path, plate, *WORDS))


def test_render_of_arrays_equals_render_of_file(plate):
    file_plate = read_plate(plate)
    camera_values = {"focal_length_mm": 50.0, "sensor_width_mm": 36.0}
    rendered = heatlens.open(file_plate.color[..., :3], file_plate.depth_m).render(
        **LENS, **camera_values
    )
    np.testing.assert_array_equal(rendered, heatlens.open(plate).render(**LENS))


def test_render_of_scene_equals_render_command(small_demo, tmp_path):
    words = ("demo", "--float", "--quality", "draft", "--f-stop", "2", "--focus-distance", "3")
    source = heatlens.open("demo")
    rendered = source.render(f_stop=2, focus_distance_m=3, quality="draft")
    np.testing.assert_array_equal(rendered[..., :3], render_by_command(tmp_path, *words))
    size = (40, 24)
    accumulated = heatlens.open("demo", size=size).render(method="accumulation", views=4)
    assert accumulated.shape == (24, 40, 4) and np.isfinite(accumulated).all()


def test_render_of_shot_file_uses_lens_of_frame(shot_file):
    shot = read_shot(shot_file)
    with heatlens.open(shot_file) as source:
        first, last = source.render(frame=1001), source.render(frame=1006)
        first_again = source.render(shot.lens_at(1001), frame=1001)
    assert not np.array_equal(first, last)
    np.testing.assert_array_equal(first, first_again)


def test_focus_at_focuses_on_depth_of_pixel(plate):
    source = heatlens.open(plate)
    expected = source.render(f_stop=2, focus_distance_m=float(read_plate(plate).depth_m[5, 8]))
    np.testing.assert_array_equal(source.render(f_stop=2, focus_at=(8, 5)), expected)


def test_render_keeps_its_context_beside_that_of_caller(plate):
    code = f"""
import heatlens, moderngl
from heatlens.fronts.api.engine import ENGINE
source = heatlens.open({str(plate)!r})
source.render(f_stop=1.4, focus_distance_m=3)
kept = ENGINE._renderer
own = moderngl.create_context(standalone=True, backend="egl", require=430)
buffer = own.buffer(b"mine")
source.render(f_stop=1.4, focus_distance_m=2)
own.__enter__()
assert buffer.read() == b"mine" and own.error == "GL_NO_ERROR"
assert ENGINE._renderer is kept
"""
    subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, check=True)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda p: heatlens.open("nothing.exr"), "nothing.exr"),
        (lambda p: heatlens.open(p, depth_channle="Z"), "depth_channle"),
        (lambda p: heatlens.open(p, size=(8, 8)), "leave size out"),
        (lambda p: heatlens.open("demo", scene_unit_m=2), "leave scene_unit_m out"),
        (lambda p: heatlens.open(p).render(qualty="draft"), "There is no argument 'qualty'"),
        (lambda p: heatlens.open(p).render(quality="best"), "draft, preview, film"),
        (lambda p: heatlens.open(p).render(f_stop=0), "f-stop must be between"),
        (lambda p: heatlens.open(p).render(focus_distance_m=2, focus_at=(1, 1)), "not both"),
        (lambda p: heatlens.open(np.ones((4, 4, 3))), "depth_m or coc_px"),
        (lambda p: heatlens.open(np.ones((4, 4, 3)), np.ones((4, 5))), r"shape \(4, 5\)"),
        (lambda p: heatlens.open(np.ones((4, 4, 3)), np.zeros((4, 4))), "above 0"),
        (lambda p: heatlens.open(np.ones((4, 4)), np.ones((4, 4))), r"\(H, W, 3\)"),
        (
            lambda p: heatlens.open([["a"]], np.ones((1, 1))),
            "cannot be read as",
        ),
        (
            lambda p: heatlens.open(np.ones((4, 4, 3)), np.ones((4, 4))).render(f_stop=2),
            "no focal length and focus distance; give them with focal_length_mm and focus_dist",
        ),
    ],
)
def test_wrong_calls_raise_heatlens_error_with_helpful_message(plate, call, words):
    with pytest.raises(HeatlensError, match=words):
        call(plate)


def test_render_in_other_thread_raises_error(plate):
    source = heatlens.open(plate)
    source.render(**LENS)
    messages: list[str] = []

    def draw() -> None:
        with pytest.raises(HeatlensError) as error:
            source.render(**LENS)
        messages.append(str(error.value))

    thread = threading.Thread(target=draw)
    thread.start()
    thread.join()
    assert "in the thread that rendered first" in messages[0]


def test_import_of_heatlens_loads_no_heavy_modules():
    code = """
import sys
import heatlens
assert not {"numpy", "moderngl", "heatlens.render.frame_renderer"} & set(sys.modules)
assert "open" in dir(heatlens)
heatlens.Lens(50, 2, 2, 36)
assert "moderngl" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, check=True)
    with pytest.raises(AttributeError, match="no attribute 'opne'"):
        heatlens.opne  # noqa: B018


def test_all_public_names_can_be_imported():
    assert all(getattr(heatlens, name) is not None for name in heatlens.__all__)
