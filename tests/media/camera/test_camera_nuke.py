"""Test the Nuke nodes of a camera: the text is parsed as Tcl, and its angles are applied."""

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
from heatlens.media.camera.nuke_write import nuke_text, unsupported_note
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
    (words,) = stack
    return words


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


def knob_value(knob: list | str, frame: int) -> float | list[float]:
    """Return a knob's value at a frame, or its values."""
    if isinstance(knob, str):
        return float(knob)
    values = [element_at(element, frame) for element in knob]
    return values[0] if len(values) == 1 else values


@pytest.mark.parametrize("unit_m", [1.0, 0.01, 0.3048, 0.0254])
def test_nuke_camera_has_lens_in_mm_and_focus_in_scene_units(tmp_path, unit_m):
    camera = moving_camera()
    write_camera(tmp_path / "cam.nk", camera, unit_m)
    knobs = knobs_of((tmp_path / "cam.nk").read_text())
    assert knobs["name"] == "hero_cam"
    for index, frame in enumerate(FRAMES):
        assert knob_value(knobs["focal"], frame) == camera.focal_length_mm[index]
        focus_m = min(camera.focus_distance_m[index], INFINITE_M)
        assert knob_value(knobs["focal_point"], frame) * unit_m == pytest.approx(focus_m, rel=1e-12)
    assert [knobs[name] for name in ("haperture", "vaperture", "fstop")] == ["36.0", "20.25", "1.3"]


@given(SHOTS)
def test_nuke_camera_keys_match_lens_of_any_shot(shot):
    knobs = knobs_of(nuke_text(camera_of_shot(shot, "cam")))
    for frame in FRAMES:
        lens = shot.lens_at(frame)
        assert knob_value(knobs["fstop"], frame) == lens.f_stop
        assert knob_value(knobs["focal"], frame) == lens.focal_length_mm
        assert knob_value(knobs["focal_point"], frame) == min(lens.focus_distance_m, INFINITE_M)


@pytest.mark.parametrize("unit_m", [1.0, 0.01])
def test_nuke_camera_translate_and_rotate_match_placement(unit_m):
    knobs = knobs_of(nuke_text(moving_camera(), unit_m))
    assert knobs["rot_order"] == "ZXY"
    for frame, eye in zip(FRAMES, dolly(), strict=True):
        x, y, z = np.radians(knob_value(knobs["rotate"], frame))
        rotation = axis_rotation("y", y) @ axis_rotation("x", x) @ axis_rotation("z", z)
        forward = np.subtract(TARGET, eye) / np.linalg.norm(np.subtract(TARGET, eye))
        assert rotation @ (0, 0, -1) == pytest.approx(forward, abs=1e-9)
        assert (rotation @ (1, 0, 0))[1] == pytest.approx(0, abs=1e-9)  # level
        assert knob_value(knobs["translate"], frame) == pytest.approx(
            np.divide(eye, unit_m), abs=1e-9
        )


def axis_rotation(axis: str, angle: float) -> np.ndarray:
    """Return a right-handed rotation about an axis by radians."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
    )


def test_nuke_camera_rotates_z_up_world_to_y_up():
    """The camera is above the origin and looks down at it, with y towards the top of its image."""
    above = ((1.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 1.0, -7.0), (0, 0, 0, 1.0))
    camera = moving_camera(world_to_camera=(above,) * 8, up_axis="z")
    knobs = knobs_of(nuke_text(camera))
    assert knob_value(knobs["translate"], 1001) == pytest.approx([0, 7, 0])
    assert knob_value(knobs["rotate"], 1001) == pytest.approx([-90, 0, 0])


@given(st.text())
def test_nuke_camera_name_is_always_an_identifier(name):
    knobs = knobs_of(nuke_text(replace(moving_camera(), name=name)))
    assert re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", knobs["name"])


def test_nuke_camera_omits_knobs_of_unknown_values():
    bare = moving_camera(f_stop=None, focus_distance_m=None, world_to_camera=None)
    assert set(knobs_of(nuke_text(bare))) == {"inputs", "focal", "haperture", "vaperture", "name"}


def test_nuke_camera_that_does_not_move_has_no_curves():
    still = world_to_camera(EYE, TARGET)
    camera = moving_camera(
        world_to_camera=(still,) * 8, focal_length_mm=(50.0,) * 8, focus_distance_m=(2.0,) * 8
    )
    assert "curve" not in nuke_text(camera)


def camera_with_constant_tracks(**opening: float):
    """Return a moving camera with constant tracks of these opening values."""
    return moving_camera(**{name: (value,) * FRAMES.count for name, value in opening.items()})


def test_nuke_defocus_nodes_have_lens_and_opening():
    camera = camera_with_constant_tracks(
        blades=5.0, blade_rotation_deg=15.0, blade_curvature=0.25, squeeze=2.0
    )
    nodes = nodes_of(nuke_text(camera, 0.01))
    assert list(nodes) == ["ZDefocus2", "Bokeh"]
    bokeh, zdefocus = nodes["Bokeh"], nodes["ZDefocus2"]
    assert bokeh["kernelType"] == '"Aperture Blades"' and zdefocus["filter_type"] == "bladed"
    knob_values = [
        float(bokeh[name]) for name in ("kNumSides", "kRotation", "kCurvature", "kAspectRatio")
    ]
    assert knob_values == [5.0, 15.0, 0.25, 0.5]
    knob_values = [float(zdefocus[name]) for name in ("blades", "rotation", "roundness", "aspect")]
    assert knob_values == [5.0, 15.0, 0.25, 0.5]
    assert (bokeh["worldScale"], float(bokeh["worldScaleMultiplier"])) == ("m", 0.01)
    for index, frame in enumerate(FRAMES):
        focus = min(camera.focus_distance_m[index], INFINITE_M) / 0.01
        assert (
            knob_value(bokeh["focalPlane"], frame) == knob_value(zdefocus["center"], frame) == focus
        )
        assert knob_value(bokeh["focalLength"], frame) == camera.focal_length_mm[index]


def test_nuke_round_opening_writes_zdefocus_node_only():
    camera = camera_with_constant_tracks(squeeze=1.0)
    nodes = nodes_of(nuke_text(camera, 0.01))
    assert list(nodes) == ["ZDefocus2"]
    zdefocus = nodes["ZDefocus2"]
    assert zdefocus["filter_type"] == "disc" and "rotation" not in zdefocus["label"]
    for index, frame in enumerate(FRAMES):
        focus = min(camera.focus_distance_m[index], INFINITE_M) / 0.01
        assert knob_value(zdefocus["center"], frame) == focus
    assert nodes_of(nuke_text(replace(camera, focus_distance_m=None))) == {}


@given(SHOTS, st.sampled_from(LensModel), st.sampled_from([640, 1998]), st.booleans())
def test_nuke_zdefocus_size_gives_blur_of_the_shot(shot, model, width, is_nominal):
    """Its blur at any depth z is size (1 - center / z), where size is half a diameter."""
    shot = replace(shot, lens=replace(shot.lens, model=model))
    camera = with_renderer_f_stop(camera_of_shot(shot, "cam"))
    unit_m = 0.01
    written = with_nominal_f_stop(camera) if is_nominal else camera
    knobs = nodes_of(nuke_text(written, unit_m))["ZDefocus2"]
    assert knobs["size"] == [["width*half_disc"]] and "width of the picture" in knobs["label"]
    for frame in FRAMES:
        center = knob_value(knobs["center"], frame)
        size = width * knob_value(knobs["half_disc"], frame)
        line = coc_line(shot.lens_at(frame), width)
        for depth_m in (0.3, 2.0, 40.0):
            blurred = 2 * size * (1 - center * unit_m / depth_m)
            assert blurred == pytest.approx(float(coc_px(depth_m, line)), rel=1e-6, abs=1e-3)


def test_nuke_nodes_name_opening_values_that_they_lack():
    camera = camera_with_constant_tracks(cat_eye=0.5, rim=-0.5, squeeze=1.0)
    omitted = unsupported_note(camera)
    assert "cat eye and rim" in omitted
    for node in nodes_of(nuke_text(camera)).values():
        assert "cat eye and rim" in node["label"]
    assert unsupported_note(camera_with_constant_tracks(blades=6.0)) == ""
    assert nodes_of(nuke_text(camera))["Bokeh"]["kernelType"] == '"Circular"'


def test_nuke_camera_of_inverse_depth_plate_adds_expression_node(tmp_path, capsys):
    """Nuke's own renders hold 1/z, for which `math depth` alone would be wrong."""
    text_of_convention = {}
    for convention in ("distance", "inverse"):
        options = PlateOptions(depth_convention=convention)
        shot = tmp_path / f"{convention}.heatlens.json"
        write_shot(shot, Shot(LENS, plate_options=options, frames=FrameRange(1, 3)))
        assert main(["camera", str(shot), "-o", str(tmp_path / f"{convention}.nk")]) == 0
        text_of_convention[convention] = (tmp_path / f"{convention}.nk").read_text()
    distance, inverse = (words_of(text) for text in text_of_convention.values())
    assert distance[::2] == ["Camera2", "ZDefocus2"]
    assert inverse[::2] == ["Camera2", "Expression", "ZDefocus2"]
    expression = dict(zip(inverse[3][::2], inverse[3][1::2], strict=True))
    assert expression["channel0"] == "depth" and "1 / depth.Z" in expression["expr0"]
    assert expression["name"] in text_of_convention["inverse"].partition("ZDefocus2 {")[2]
    assert "1/z" not in text_of_convention["distance"]
