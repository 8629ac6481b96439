"""Test pinhole plates of scenes: overscan, and deep files with hidden surfaces."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.plate.deep.deep_write import check_deep_fits, deep_samples, write_deep
from heatlens.media.plate.read import read_plate
from heatlens.render.frame_renderer import FrameRenderer
from support.fragment_lists import packed_lists
from support.plates import plate_of

SCENE = ("render", "demo", "--pinhole", "--size=64x40", "--frame=120", "--quiet")
LENS = ("--f-stop=2", "--focus-distance=3")


@pytest.fixture(scope="module")
def plates(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("plates")
    options = {"plain": (), "wide": ("--overscan=5",), "deep": ("--overscan=5", "--deep")}
    for name, pinhole_options in options.items():
        assert main([*SCENE, *LENS, *pinhole_options, "-o", str(folder / f"{name}.exr")]) == 0
    return {name: folder / f"{name}.exr" for name in options}


def test_overscan_option_adds_pixels_around_frame(plates):
    plain, wide = read_plate(plates["plain"]), read_plate(plates["wide"])
    assert wide.display_window == plain.data_window == Box(0, 0, 64, 40)
    assert wide.data_window == Box(-5, -5, 69, 45)
    assert np.array_equal(wide.color[5:45, 5:69], plain.color)
    assert np.array_equal(wide.depth_m[5:45, 5:69], plain.depth_m)


def test_deep_file_flattens_to_picture_and_has_hidden_samples(plates):
    wide, deep = read_plate(plates["wide"]), read_plate(plates["deep"])
    assert deep.data_window == wide.data_window
    assert deep.fragments is not None and deep.fragments.count > 64 * 40
    relative_difference = np.abs(deep.color - wide.color)[..., :3] / (wide.color[..., :3] + 0.05)
    assert np.quantile(relative_difference, 0.9) < 0.01  # lamps in front of each other are the rest
    assert relative_difference.mean() < 0.02


def test_small_deep_plate_suggests_larger_size(tmp_path, capsys):
    words = [word for word in SCENE if word != "--quiet"]
    out = ("-o", str(tmp_path / "deep.exr"))
    assert main([*words, *LENS, "--deep", *out]) == 0
    message = capsys.readouterr().err
    assert "at 2 times its size" in message
    assert "--size 128x80 and" in message
    surfaces = message.partition("deep: ")[2].partition(" a pixel")[0]
    assert (
        surfaces.endswith(" surfaces")
        and f"{surfaces} a pixel" in read_plate(Path(out[1])).notes[0]
    )
    assert main([*words, *LENS, "--pinhole", *out]) == 0
    assert "its size" not in capsys.readouterr().err


def test_overscan_auto_depends_on_lens(tmp_path):
    def margin(*lens: str) -> int:
        path = tmp_path / "auto.exr"
        assert main([*SCENE, *lens, "--overscan=auto", "-o", str(path)]) == 0
        return -read_plate(path).data_window.x0

    assert margin("--f-stop=22", "--focus-distance=3") <= 1
    assert margin("--f-stop=1", "--focus-distance=1") > 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--overscan=4",), "Give --pinhole too"),
        (("--deep",), "Give --pinhole too"),
        (("--pinhole", "--overscan=auto"), "Give --f-stop and --focus-distance"),
        (("--pinhole", "--deep", "--compression=piz"), "always compressed as zips"),
        (("--pinhole", "--overscan=99", "--size=64x40"), "at most 8"),
        (("--pinhole", "--overscan=x"), "neither a number of pixels"),
        (("--pinhole", "--deep", "-o", "out.png"), "not an EXR"),
    ],
)
def test_render_rejects_impossible_pinhole_options(capsys, tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(["render", "demo", "-o", "out.exr", *options])
    except SystemExit as refused:  # argparse's own sentence
        code = int(str(refused.code))
    assert code == 2
    assert message in capsys.readouterr().err.replace("\n", " ")
    assert list(tmp_path.iterdir()) == []


def test_deep_file_written_and_read_gives_same_plate(renderer: FrameRenderer, tmp_path):
    rng = np.random.default_rng(2)
    color = rng.uniform(0.1, 1.0, (12, 16, 3)).astype(np.float32)
    plate = plate_of(color, np.full((12, 16), 1.0, np.float32))
    counts = np.zeros(12 * 16, np.int64)
    counts[::3] = 1
    rgba = np.append(rng.uniform(0.1, 1, (counts.sum(), 3)), np.ones((counts.sum(), 1)), axis=1)
    lists = packed_lists(
        counts, np.zeros(12 * 16, bool), rgba.astype(np.float32), np.full(counts.sum(), 3.0, "f4")
    )
    deep_plate = replace(plate, fragments=lists)
    write_deep(tmp_path / "deep.exr", deep_plate, {}, half=False)
    read_back = read_plate(tmp_path / "deep.exr")
    assert np.array_equal(read_back.color, deep_plate.color)
    assert np.array_equal(read_back.depth_m, deep_plate.depth_m)
    assert read_back.fragments is not None
    assert np.array_equal(read_back.fragments.starts, lists.starts)
    assert np.allclose(read_back.fragments.color, lists.color, rtol=2e-3)
    shot = Shot(Lens(50.0, 1.0, 3.0, 36.0), DefocusSettings(quality=Quality.DRAFT))
    renderer.load(deep_plate)
    expected = renderer.pixels(shot)
    renderer.load(read_back)
    assert np.allclose(renderer.pixels(shot), expected, atol=2e-3)


def test_deep_samples_begin_with_visible_surface():
    plate = plate_of(np.full((1, 2, 3), 0.5, np.float32), np.full((1, 2), 2.0, np.float32))
    rgba = np.array([[1, 1, 1, 0.25], [0, 0, 0, 1], [0.2, 0.2, 0.2, 1]], np.float32)
    lists = packed_lists(
        np.array([2, 1]), np.array([True, False]), rgba, np.array([1, 4, 8], np.float32)
    )
    counts, samples = deep_samples(replace(plate, fragments=lists))
    assert counts.tolist() == [2, 2]
    expected = [[0.25] * 4 + [1], [0, 0, 0, 1, 4], [0.5] * 3 + [1, 2], [0.2] * 3 + [1, 8]]
    assert np.allclose(samples, expected, atol=1e-3)


def test_check_deep_fits_rejects_size_beyond_memory():
    with pytest.raises(InputError, match=r"8000x4000.*fits"):
        check_deep_fits("deep.exr", 8000, 4000)


@pytest.mark.parametrize("f_stop", [1.4, 2.0, 2.8, 5.6])
def test_overscan_auto_is_same_with_and_without_deep(tmp_path, f_stop):
    """A plate that is not deep is drawn at twice the size, whose rounding must not matter."""
    words = [word for word in SCENE if not word.startswith("--size")]
    words += ["--size=96x54", f"--f-stop={f_stop}", "--focus-distance=5.6", "--overscan=auto"]
    windows = []
    for deep_options in ((), ("--deep",)):
        path = tmp_path / f"{len(deep_options)}.exr"
        assert main([*words, *deep_options, "-o", str(path)]) == 0
        windows.append(read_plate(path).data_window)
    assert windows[0] == windows[1]
