"""The Nuke node says what the camera is: its text is taken apart as Tcl, and its angles applied."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import write_camera
from heatlens.media.camera.nuke_write import left_out, nuke_text
from heatlens.media.camera.samples import INFINITE_M, with_nominal_f_stop, with_renderer_f_stop
from heatlens.media.documents.shot_file import write_shot
from heatlens.render.source.named import camera_of_shot
from support.cameras import EYE, FRAMES, SHOTS, TARGET, dolly, moving_camera, world_to_camera

LENS = Lens(50.0, 2.0, 3.0, 36.0)


def words_of(text: str) -> list:
    """Return words of Tcl; one in braces is the list of those in it."""
    stack: list[list] = [[]]
    for token in re.findall(r'"(?:\\.|[^"\\])*"|[{}]|[^\s{}]+', text):
        if token == "{":
            stack.append([])
        elif token == "}":
            stack[-2].append(stack.pop())
        else:
            stack[-1].append(token)
    (whole,) = stack
    return whole


def knobs_of(text: str) -> dict:
    """Return the knobs of the camera, which is the first node."""
    kind, body, *_ = words_of(text)
    assert kind == "Camera2"
    return dict(zip(body[::2], body[1::2], strict=True))


def nodes_of(text: str) -> dict[str, dict]:
    """Return the knobs of each node by its class."""
    words = words_of(text)
    return {
        kind: dict(zip(body[::2], body[1::2], strict=True))
        for kind, body in zip(words[2::2], words[3::2], strict=True)
    }


def element_at(element: list | str, frame: int) -> float:
    """Return a number, or the key that a curve has at a frame."""
    if isinstance(element, str):
        return float(element)
    assert element[0] == "curve"
    keys = dict(zip(element[1::2], element[2::2], strict=True))
    return float(keys[f"x{frame}"])


def at(knob: list | str, frame: int) -> float | list[float]:
    """Return a knob's value at a frame, or its values."""
    if isinstance(knob, str):
        return float(knob)
    values = [element_at(element, frame) for element in knob]
    return values[0] if len(values) == 1 else values


@pytest.mark.parametrize("unit_m", [1.0, 0.01, 0.3048, 0.0254])
def test_the_lens_is_in_millimetres_and_the_focus_in_the_scenes_unit(tmp_path, unit_m):
    camera = moving_camera()
    write_camera(tmp_path / "cam.nk", camera, unit_m)
    knobs = knobs_of((tmp_path / "cam.nk").read_text())
    assert knobs["name"] == "hero_cam"
    for index, frame in enumerate(FRAMES):
        assert at(knobs["focal"], frame) == camera.focal_length_mm[index]
        focus_m = min(camera.focus_distance_m[index], INFINITE_M)
        assert at(knobs["focal_point"], frame) * unit_m == pytest.approx(focus_m, rel=1e-12)
    assert [knobs[name] for name in ("haperture", "vaperture", "fstop")] == ["36.0", "20.25", "1.3"]


@given(SHOTS)
def test_the_lens_of_any_shot_is_at_every_frame(shot):
    knobs = knobs_of(nuke_text(camera_of_shot(shot, "cam")))
    for frame in FRAMES:
        lens = shot.lens_at(frame)
        assert at(knobs["fstop"], frame) == lens.f_stop
        assert at(knobs["focal"], frame) == lens.focal_length_mm
        assert at(knobs["focal_point"], frame) == min(lens.focus_distance_m, INFINITE_M)


@pytest.mark.parametrize("unit_m", [1.0, 0.01])
def test_translation_and_angles_put_the_camera_where_it_is(unit_m):
    knobs = knobs_of(nuke_text(moving_camera(), unit_m))
    assert knobs["rot_order"] == "ZXY"
    for frame, eye in zip(FRAMES, dolly(), strict=True):
        x, y, z = np.radians(at(knobs["rotate"], frame))
        turn = about("y", y) @ about("x", x) @ about("z", z)
        forward = np.subtract(TARGET, eye) / np.linalg.norm(np.subtract(TARGET, eye))
        assert turn @ (0, 0, -1) == pytest.approx(forward, abs=1e-9)
        assert (turn @ (1, 0, 0))[1] == pytest.approx(0, abs=1e-9)  # level
        assert at(knobs["translate"], frame) == pytest.approx(np.divide(eye, unit_m), abs=1e-9)


def about(axis: str, angle: float) -> np.ndarray:
    """Return a right-handed rotation about an axis by radians."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
    )


def test_a_world_with_z_up_is_laid_down():
    """A camera above the origin that looks down at it, with y to the top of its picture."""
    above = ((1.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 1.0, -7.0), (0, 0, 0, 1.0))
    camera = moving_camera(world_to_camera=(above,) * 8, up_axis="z")
    knobs = knobs_of(nuke_text(camera))
    assert at(knobs["translate"], 1001) == pytest.approx([0, 7, 0])
    assert at(knobs["rotate"], 1001) == pytest.approx([-90, 0, 0])


@given(st.text())
def test_no_name_breaks_the_node(name):
    knobs = knobs_of(nuke_text(replace(moving_camera(), name=name)))
    assert re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", knobs["name"])


def test_what_is_not_told_leaves_nukes_own():
    bare = moving_camera(f_stop=None, focus_distance_m=None, world_to_camera=None)
    assert set(knobs_of(nuke_text(bare))) == {"inputs", "focal", "haperture", "vaperture", "name"}


def test_a_camera_that_stands_still_has_no_curves():
    still = world_to_camera(EYE, TARGET)
    camera = moving_camera(
        world_to_camera=(still,) * 8, focal_length_mm=(50.0,) * 8, focus_distance_m=(2.0,) * 8
    )
    assert "curve" not in nuke_text(camera)


def shaped(**opening: float):
    """Return a moving camera whose opening has a shape, its tracks constant."""
    return moving_camera(**{name: (value,) * FRAMES.count for name, value in opening.items()})


def test_the_nodes_that_defocus_have_the_lens_and_its_opening():
    camera = shaped(blades=5.0, blade_rotation_deg=15.0, blade_curvature=0.25, squeeze=2.0)
    nodes = nodes_of(nuke_text(camera, 0.01))
    assert list(nodes) == ["ZDefocus2", "Bokeh"]
    bokeh, zdefocus = nodes["Bokeh"], nodes["ZDefocus2"]
    assert bokeh["kernelType"] == '"Aperture Blades"' and zdefocus["filter_type"] == "bladed"
    told = [float(bokeh[name]) for name in ("kNumSides", "kRotation", "kCurvature", "kAspectRatio")]
    assert told == [5.0, 15.0, 0.25, 0.5]
    told = [float(zdefocus[name]) for name in ("blades", "rotation", "roundness", "aspect")]
    assert told == [5.0, 15.0, 0.25, 0.5]
    assert (bokeh["worldScale"], float(bokeh["worldScaleMultiplier"])) == ("m", 0.01)
    for index, frame in enumerate(FRAMES):
        focus = min(camera.focus_distance_m[index], INFINITE_M) / 0.01
        assert at(bokeh["focalPlane"], frame) == at(zdefocus["center"], frame) == focus
        assert at(bokeh["focalLength"], frame) == camera.focal_length_mm[index]


def test_a_round_opening_has_the_focus_in_zdefocus_alone():
    camera = shaped(squeeze=1.0)
    nodes = nodes_of(nuke_text(camera, 0.01))
    assert list(nodes) == ["ZDefocus2"]
    zdefocus = nodes["ZDefocus2"]
    assert zdefocus["filter_type"] == "disc" and "rotation" not in zdefocus["label"]
    for index, frame in enumerate(FRAMES):
        focus = min(camera.focus_distance_m[index], INFINITE_M) / 0.01
        assert at(zdefocus["center"], frame) == focus
    assert nodes_of(nuke_text(replace(camera, focus_distance_m=None))) == {}


@given(SHOTS, st.sampled_from(LensModel), st.sampled_from([640, 1998]), st.booleans())
def test_the_size_of_zdefocus_makes_the_discs_of_the_shot(shot, model, width, is_nominal):
    """At any depth z its blur is size (1 - center / z), and the size half a diameter."""
    shot = replace(shot, lens=replace(shot.lens, model=model))
    camera = with_renderer_f_stop(camera_of_shot(shot, "cam"))
    unit_m = 0.01
    written = with_nominal_f_stop(camera) if is_nominal else camera
    knobs = nodes_of(nuke_text(written, unit_m))["ZDefocus2"]
    assert knobs["size"] == [["width*half_disc"]] and "width of the picture" in knobs["label"]
    for frame in FRAMES:
        center, size = at(knobs["center"], frame), width * at(knobs["half_disc"], frame)
        line = coc_line(shot.lens_at(frame), width)
        for depth_m in (0.3, 2.0, 40.0):
            blurred = 2 * size * (1 - center * unit_m / depth_m)
            assert blurred == pytest.approx(float(coc_px(depth_m, line)), rel=1e-6, abs=1e-3)


def test_what_the_nodes_cannot_hold_is_said_in_them_and_to_the_user():
    camera = shaped(cat_eye=0.5, rim=-0.5, squeeze=1.0)
    said = left_out(camera)
    assert "cat eye and rim" in said
    for node in nodes_of(nuke_text(camera)).values():
        assert "cat eye and rim" in node["label"]
    assert left_out(shaped(blades=6.0)) == ""
    assert nodes_of(nuke_text(camera))["Bokeh"]["kernelType"] == '"Circular"'


def test_a_plate_of_1_over_z_gets_the_node_that_turns_it_into_distances(tmp_path, capsys):
    """Nuke's own renders hold 1/z, for which `math depth` alone would be wrong."""
    made = {}
    for convention in ("distance", "inverse"):
        options = PlateOptions(depth_convention=convention)
        shot = tmp_path / f"{convention}.heatlens.json"
        write_shot(shot, Shot(LENS, plate_options=options, frames=FrameRange(1, 3)))
        assert main(["camera", str(shot), "-o", str(tmp_path / f"{convention}.nk")]) == 0
        made[convention] = (tmp_path / f"{convention}.nk").read_text()
    plain, turned = (words_of(text) for text in made.values())
    assert plain[::2] == ["Camera2", "ZDefocus2"]
    assert turned[::2] == ["Camera2", "Expression", "ZDefocus2"]
    expression = dict(zip(turned[3][::2], turned[3][1::2], strict=True))
    assert expression["channel0"] == "depth" and "1 / depth.Z" in expression["expr0"]
    assert expression["name"] in made["inverse"].partition("ZDefocus2 {")[2]
    assert "1/z" not in made["distance"]
