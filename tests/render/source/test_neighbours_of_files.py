"""Neighbor frames used for hidden surfaces: by default, by option, in parts, of damaged files."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import heatlens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.media.frame_cache import neighbour_reader, sequence_reader
from heatlens.media.frame_cache.neighbour_reader import NeighbourReader
from heatlens.media.frame_cache.plate_shelf import plate_bytes
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence_search import find_sequence
from heatlens.render.source.plate_source import PlateSource
from support.command_line import stderr_of_run
from support.dolly_plates import FIRST, LAST, write_dolly
from support.watched_calls import watch_calls

ALL = range(FIRST, LAST + 1)
LENS = ("--focal-length", "120", "--sensor-width", "36", "--f-stop", "1.4", "--focus-distance", "9")


@pytest.fixture(scope="module")
def dolly(tmp_path_factory):
    return write_dolly(tmp_path_factory.mktemp("dolly"))


@pytest.fixture(scope="module")
def untold(tmp_path_factory):
    """Write the same sequence without the camera in the headers."""
    return write_dolly(tmp_path_factory.mktemp("untold"), has_camera=False)


def plate_source(pattern, **options):
    return PlateSource(pattern, find_sequence(pattern), PlateOptions(**options))


def path_of(pattern, frame):
    return Path(pattern.replace("####", f"{frame:04d}"))


def hidden_bytes(plate):
    """Return the plate's hidden surfaces as bytes, None if it has none."""
    return None if plate.fragments is None else plate.fragments.words.tobytes()


def test_sequence_with_camera_headers_has_hidden_surfaces(dolly):
    plates = plate_source(dolly)
    assert plates.read.neighbourhood.count == 2
    plate = plates.read(path_of(dolly, 4))
    assert hidden_bytes(plate) is not None and plate.behind[0].hidden_part > 0.05
    without_neighbours = plate_source(dolly, neighbours=0).read(path_of(dolly, 4))
    single_plate = read_plate(path_of(dolly, 4))
    assert hidden_bytes(without_neighbours) is None
    assert (
        without_neighbours.color.tobytes() == single_plate.color.tobytes() == plate.color.tobytes()
    )


def test_sequence_without_camera_uses_no_neighbours_and_says_why(untold):
    assert plate_source(untold).read.neighbourhood.count == 0
    near = plate_source(untold, neighbours=2).read.neighbourhood
    assert near.count == 0 and "worldToCamera" in near.words
    assert hidden_bytes(plate_source(untold, neighbours=2).read(path_of(untold, 4))) is None


def test_sequence_of_still_camera_uses_neighbours_without_header(tmp_path):
    still = write_dolly(tmp_path, has_camera=False, moves=False)
    near = plate_source(still, neighbours=2).read.neighbourhood
    assert near.count == 2 and "stands still" in near.words


def test_single_file_uses_no_neighbours(dolly, tmp_path):
    shutil.copy(path_of(dolly, 4), tmp_path / "one.0004.exr")
    assert plate_source(str(tmp_path / "one.0004.exr")).read.neighbourhood.count == 0
    assert plate_source(str(tmp_path / "one.0004.exr"), neighbours=2).read.neighbourhood.count == 0


def test_files_of_frame_include_its_neighbours(dolly):
    files = plate_source(dolly, neighbours=1).files_of(path_of(dolly, 4))
    assert files[0] == path_of(dolly, 4) and set(files[1:]) <= {path_of(dolly, it) for it in ALL}
    assert len(files) == 3
    assert plate_source(dolly, neighbours=0).files_of(path_of(dolly, 4)) == (path_of(dolly, 4),)
    # Where a side is missing, as many in all.
    assert len(plate_source(dolly, neighbours=1).files_of(path_of(dolly, FIRST))) == 3


def test_hidden_surfaces_do_not_depend_on_read_order(dolly):
    whole = {frame: hidden_bytes(plate_source(dolly).read(path_of(dolly, frame))) for frame in ALL}
    backwards = plate_source(dolly).read
    assert {it: hidden_bytes(backwards(path_of(dolly, it))) for it in reversed(ALL)} == whole


def test_neighbour_reader_reads_each_plate_once_within_memory(dolly, monkeypatch):
    one_plate_bytes = plate_bytes(sequence_reader.read_plate(path_of(dolly, 1)))
    calls = watch_calls(monkeypatch, sequence_reader, "read_plate")
    plates = NeighbourReader(PlateOptions(), find_sequence(dolly))
    for frame in ALL:
        plates(path_of(dolly, frame))
    paths = [path for path, *_ in calls]
    assert sorted(paths) == sorted(set(paths))
    monkeypatch.setattr(neighbour_reader, "_SHELF_BYTES", 2 * one_plate_bytes)
    small_reader = NeighbourReader(PlateOptions(), find_sequence(dolly))
    for frame in ALL:
        small_reader(path_of(dolly, frame))
        assert small_reader._plate_cache.plates.bytes_in_use <= neighbour_reader._SHELF_BYTES


def test_neighbour_reader_rereads_changed_frame(tmp_path):
    pattern = write_dolly(tmp_path)
    plates = NeighbourReader(PlateOptions(), find_sequence(pattern))
    before = plates.read_alone(path_of(pattern, 4))
    assert plates.read_alone(path_of(pattern, 4)) is before
    shutil.copy(path_of(pattern, 5), path_of(pattern, 4))
    assert plates.read_alone(path_of(pattern, 4)).color.tobytes() != before.color.tobytes()


def test_damaged_neighbour_is_noted_and_others_are_used(tmp_path):
    pattern = write_dolly(tmp_path)
    data = path_of(pattern, 5).read_bytes()
    path_of(pattern, 5).write_bytes(data[: len(data) // 2])
    plates = NeighbourReader(PlateOptions(), find_sequence(pattern))
    hidden_surfaces = plates.add_hidden_surfaces(plates.read_alone(path_of(pattern, 4)))
    assert hidden_surfaces.frames and 5 not in hidden_surfaces.frames
    (note,) = (note for note in hidden_surfaces.plate.notes if "Frame 5 is not used" in note)
    assert "dolly.0005.exr" in note


def test_render_of_named_frame_uses_neighbours_only_with_option(dolly, tmp_path, capsys):
    frame, shared = path_of(dolly, 4), ("render", path_of(dolly, 4), *LENS)
    stderr = stderr_of_run(capsys, 0, *shared, "-o", tmp_path / "with.exr", "--neighbours", "2")
    assert "2 frames on either side" in stderr and "show" in stderr
    stderr = stderr_of_run(capsys, 0, *shared, "-o", tmp_path / "alone.exr")
    assert "neighbour" not in stderr.lower()
    stderr_of_run(capsys, 0, *shared, "-o", tmp_path / "off.exr", "--neighbours", "0")
    pictures = {
        name: read_plate(tmp_path / f"{name}.exr", PlateOptions(depth_source=str(frame))).color
        for name in ("with", "alone", "off")
    }
    assert np.array_equal(pictures["alone"], pictures["off"])
    assert not np.array_equal(pictures["with"], pictures["off"])


def test_behind_out_file_gives_same_picture_as_neighbours(dolly, tmp_path, capsys):
    shared = ("render", path_of(dolly, 4), *LENS)
    out, clean = tmp_path / "with.exr", tmp_path / "clean.####.exr"
    stderr_of_run(capsys, 0, *shared, "-o", out, "--neighbours", "2", "--behind-out", clean)
    written = tmp_path / "clean.0004.exr"
    again = tmp_path / "again.exr"
    stderr_of_run(capsys, 0, *shared, "-o", again, "--behind", written)
    depth = PlateOptions(depth_source=str(path_of(dolly, 4)))
    one, other = (read_plate(path, depth).color for path in (out, again))
    inner = np.s_[12:-12, 12:-12]  # nearer to the border, what was found beyond it blurs in
    assert np.abs(one - other)[inner].max() < 2e-3


@pytest.mark.parametrize(
    ("words", "message_part"),
    [
        (("--behind-out", "clean.exr"), "add --neighbours"),
        (("--neighbours", "2", "--behind-out", "clean.png"), "EXR"),
        (("--neighbours", "-1"), "0 to 64"),
    ],
)
def test_render_refuses_invalid_neighbour_options(dolly, tmp_path, capsys, words, message_part):
    shared = ("render", path_of(dolly, 4), "-o", tmp_path / "o.exr", *LENS)
    assert message_part in stderr_of_run(capsys, 2, *shared, *words)
    assert not (tmp_path / "o.exr").exists()


def test_behind_out_without_hidden_surfaces_fails(tmp_path, capsys):
    still = path_of(write_dolly(tmp_path, moves=False), 4)
    words = ("--neighbours", "2", "--behind-out", tmp_path / "clean.exr")
    stderr = stderr_of_run(capsys, 2, "render", still, "-o", tmp_path / "o.exr", *LENS, *words)
    assert "clean.exr" in stderr and not (tmp_path / "clean.exr").exists()


def test_info_reports_neighbours_in_use(dolly, untold, capsys):
    assert main(["info", dolly, "--json"]) == 0
    near = json.loads(capsys.readouterr().out)["neighbours"]
    assert near["count"] == 2 and near["step"] >= 1 and 0.1 < near["found"] <= 1
    assert main(["info", dolly]) == 0
    assert "2 frames on either side" in capsys.readouterr().out
    assert main(["info", untold]) == 0
    assert "either side" not in capsys.readouterr().out


def test_damaged_first_frame_does_not_prevent_hidden_surfaces(tmp_path):
    pattern = write_dolly(tmp_path)
    path_of(pattern, FIRST).write_bytes(b"damaged")
    assert hidden_bytes(plate_source(pattern).read(path_of(pattern, 4))) is not None


def test_export_with_neighbours_in_parts_equals_whole_export(dolly, tmp_path, capsys):
    words = ("export", dolly, *LENS)
    assert main([*words, "-o", str(tmp_path / "whole.####.exr"), "--frames", "3-5"]) == 0
    for part in ("3", "4-5"):
        assert main([*words, "-o", str(tmp_path / "parts.####.exr"), "--frames", part]) == 0
    for frame in (3, 4, 5):
        whole, part = (tmp_path / f"{it}.{frame:04d}.exr" for it in ("whole", "parts"))
        depth = PlateOptions(depth_source=str(path_of(dolly, frame)))
        assert np.array_equal(read_plate(whole, depth).color, read_plate(part, depth).color)
    capsys.readouterr()


def test_python_api_uses_neighbours_unless_set_to_zero(dolly):
    values = {"focal_length_mm": 120, "sensor_width_mm": 36, "f_stop": 1.4, "focus_distance_m": 9}
    with heatlens.open(dolly) as usual, heatlens.open(dolly, neighbours=0) as none:
        pictures = [it.render(frame=4, **values) for it in (usual, none)]
    assert not np.array_equal(*pictures)
