"""Test that messages of commands about a source and its lens are warnings and notes in Python.

Nothing is drawn here: what is tested comes before the first pixel.
"""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import heatlens
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.fronts.api.engine import ENGINE
from heatlens.fronts.api.notes import use_python_names
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from support.command_line import CAMERA, channels
from support.exr_files import rgb, write_file

FAR_LENS = {"f_stop": 1.4, "focus_distance_m": 3, "focal_length_mm": 50}
DOUBT = "The focus at 3 m lies nearer than everything in the picture (120 m to 800 m)"


@pytest.fixture(scope="module", autouse=True)
def pinhole_engine():
    """Replace the renderer by one that returns the pinhole picture."""
    renderer = SimpleNamespace(loaded=None, pixels=lambda shot, frame: renderer.loaded.plate.color)
    renderer.load = lambda plate: setattr(renderer, "loaded", SimpleNamespace(plate=plate))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ENGINE, "renderer", lambda: renderer)
        ENGINE._loaded = None
        yield
        ENGINE._loaded = None


@pytest.fixture(scope="module")
def in_centimetres(tmp_path_factory):
    """Return a plate whose depths are 1.2 to 8 m, written in centimetres."""
    depth = np.broadcast_to(np.linspace(120, 800, 16, dtype=np.float32), (10, 16)).copy()
    return write_file(tmp_path_factory.mktemp("notes") / "cm.exr", rgb(10, 16) | {"Z": depth})


def warnings_of(call) -> list[str]:
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always")
        call()
    assert all(warning.category is heatlens.HeatlensWarning for warning in caught_warnings)
    assert all(
        warning.filename == __file__ for warning in caught_warnings
    )  # the line of the caller is named
    return [str(warning.message) for warning in caught_warnings]


def test_doubt_is_warned_once_per_source_and_kept_as_note(in_centimetres):
    source = heatlens.open(in_centimetres)
    assert source.notes == ()
    messages = warnings_of(lambda: source.render(**FAR_LENS))
    assert [sentence for sentence in messages if sentence.startswith(DOUBT)]
    assert set(messages) <= set(source.notes)
    assert any(note.startswith("depth: Z, metres, ") for note in source.notes)
    assert warnings_of(lambda: source.render(**FAR_LENS)) == []
    assert warnings_of(lambda: heatlens.open(in_centimetres).render(**FAR_LENS)) == messages


def test_doubt_names_python_argument_that_corrects_it(in_centimetres):
    (warning,) = warnings_of(lambda: heatlens.open(in_centimetres).render(**FAR_LENS))
    assert "say scene_unit_m=0.01" in warning
    assert (
        warnings_of(lambda: heatlens.open(in_centimetres, scene_unit_m=0.01).render(**FAR_LENS))
        == []
    )


def test_warning_as_error_is_raised_each_time(in_centimetres):
    source = heatlens.open(in_centimetres)
    for _ in range(2):
        with warnings.catch_warnings():
            warnings.simplefilter("error", heatlens.HeatlensWarning)
            with pytest.raises(heatlens.HeatlensWarning, match="lies nearer than everything"):
                source.render(**FAR_LENS)


def test_strict_raises_same_message_as_command_line(in_centimetres, tmp_path, capsys):
    words = ("--f-stop", "1.4", "--focus-distance", "3", "--focal-length", "50", "--strict")
    assert main(["render", str(in_centimetres), *words, "-o", str(tmp_path / "o.exr")]) == 2
    refusal = capsys.readouterr().err.strip().splitlines()[-1].removeprefix("heatlens: ")
    with pytest.raises(heatlens.HeatlensError) as error:
        heatlens.open(in_centimetres, strict=True).render(**FAR_LENS)
    assert str(error.value) == use_python_names(refusal)


def test_strict_applies_to_arrays():
    arrays = np.ones((4, 4, 3)), np.full((4, 4), 120.0)
    assert (
        DOUBT.partition("(")[0] in warnings_of(lambda: heatlens.open(*arrays).render(**FAR_LENS))[0]
    )
    with pytest.raises(heatlens.HeatlensError, match="focus at 3"):
        heatlens.open(*arrays, strict=True).render(**FAR_LENS)


def test_shot_is_doubted_only_if_doubtful_at_every_key(in_centimetres, tmp_path):
    """A pull may begin in front of everything without a warning, as on the command line."""
    lens = heatlens.Lens(50, 1.4, 0.5, 36)
    pull = LensCurves(focus_distance_m=Curve((Key(1, 0.5), Key(9, 4.0))))
    strict = PlateOptions(strict=True, scene_unit_m=0.01)
    shot = Shot(lens, source=str(in_centimetres), curves=pull, plate_options=strict)
    path = tmp_path / "s.heatlens.json"
    write_shot(path, shot)
    assert warnings_of(lambda: heatlens.open(path).render(frame=1)) == []
    with pytest.raises(heatlens.HeatlensError, match="lies nearer than everything"):
        heatlens.open(path).render(frame=1, focus_distance_m=0.5)
    write_shot(path, replace(shot, curves=LensCurves()))
    with pytest.raises(heatlens.HeatlensError, match="lies nearer than everything"):
        heatlens.open(path).render()


def test_repaired_pixels_raise_warning(tmp_path):
    broken = channels()
    broken["R"][3, 3] = np.nan
    path = write_file(tmp_path / "nan.exr", broken, **CAMERA)
    (message,) = warnings_of(heatlens.open(path).render)
    assert "1 of 160 pixels had NaN" in message


def test_lens_values_without_effect_on_coc_plate_are_warned():
    source = heatlens.open(np.ones((4, 4, 3)), coc_px=np.ones((4, 4)))
    (message,) = warnings_of(lambda: source.render(f_stop=2, blades=5))
    assert "f_stop" in message and "blades" not in message


@pytest.mark.parametrize(
    ("sentence", "expected"),
    [
        ("say --scene-unit cm; if", "say scene_unit_m=0.01; if"),
        ("say --focus-distance 300cm.", "say focus_distance_m=3."),
        ("say --focal-length 1.5.", "say focal_length_mm=1.5."),
        ("--focal-length and --sensor-width are", "focal_length_mm and sensor_width_mm are"),
        ("with --focus-at, or see --scene-unit.", "with focus_at, or see scene_unit_m."),
        ("Give --near and --far.", "Give near_m and far_m."),
        ("--depth-convention distance", "depth_convention distance"),
        ("--missing hold", "--missing hold"),
    ],
)
def test_use_python_names_replaces_options_by_arguments(sentence, expected):
    assert use_python_names(sentence) == expected
