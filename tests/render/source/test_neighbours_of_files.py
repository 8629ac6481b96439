"""Which neighbours a plate is read with: by itself, by option, in parts, of damaged files."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import heatlens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.main import main
from heatlens.media.frame_cache import sequence_reader
from heatlens.media.frame_cache.plate_shelf import plate_bytes
from heatlens.media.frame_cache.sequence_reader import NeighbourReader
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence import find_sequence
from heatlens.render.source.plate_source import PlateSource
from support.command_line import stderr_of_run
from support.dolly_plates import FIRST, LAST, write_dolly

ALL = range(FIRST, LAST + 1)
LENS = ("--focal-length", "120", "--sensor-width", "36", "--f-stop", "1.4", "--focus-distance", "9")


@pytest.fixture(scope="module")
def dolly(tmp_path_factory):
    return write_dolly(tmp_path_factory.mktemp("dolly"))


@pytest.fixture(scope="module")
def untold(tmp_path_factory):
    """The same without the camera in the headers."""
    return write_dolly(tmp_path_factory.mktemp("untold"), has_camera=False)


def source(pattern, **options):
    return PlateSource(pattern, find_sequence(pattern), PlateOptions(**options))


def path_of(pattern, frame):
    return Path(pattern.replace("####", f"{frame:04d}"))


def hidden(plate):
    """Return what the plate knows of hidden surfaces, as bytes."""
    return None if plate.fragments is None else plate.fragments.words.tobytes()


def test_a_sequence_whose_headers_tell_the_camera_knows_what_is_hidden(dolly):
    plates = source(dolly)
    assert plates.read.neighbourhood.count == 2
    plate = plates.read(path_of(dolly, 4))
    assert hidden(plate) is not None and plate.behind[0].hidden_part > 0.05
    none = source(dolly, neighbours=0).read(path_of(dolly, 4))
    alone = read_plate(path_of(dolly, 4))
    assert hidden(none) is None
    assert none.color.tobytes() == alone.color.tobytes() == plate.color.tobytes()


def test_without_a_camera_nothing_is_used_unless_asked_and_then_it_is_told_why(untold):
    assert source(untold).read.neighbourhood.count == 0
    near = source(untold, neighbours=2).read.neighbourhood
    assert near.count == 0 and "worldToCamera" in near.words
    assert hidden(source(untold, neighbours=2).read(path_of(untold, 4))) is None


def test_a_camera_that_stands_needs_no_header(tmp_path):
    still = write_dolly(tmp_path, has_camera=False, moves=False)
    near = source(still, neighbours=2).read.neighbourhood
    assert near.count == 2 and "stands still" in near.words


def test_a_single_file_uses_none_by_itself(dolly, tmp_path):
    shutil.copy(path_of(dolly, 4), tmp_path / "one.0004.exr")
    assert source(str(tmp_path / "one.0004.exr")).read.neighbourhood.count == 0
    assert source(str(tmp_path / "one.0004.exr"), neighbours=2).read.neighbourhood.count == 0


def test_the_files_of_a_frame_are_those_of_its_neighbours_too(dolly):
    files = source(dolly, neighbours=1).files_of(path_of(dolly, 4))
    assert files[0] == path_of(dolly, 4) and set(files[1:]) <= {path_of(dolly, it) for it in ALL}
    assert len(files) == 3
    assert source(dolly, neighbours=0).files_of(path_of(dolly, 4)) == (path_of(dolly, 4),)
    # Where a side is missing, as many in all.
    assert len(source(dolly, neighbours=1).files_of(path_of(dolly, FIRST))) == 3


def test_the_whole_and_its_parts_are_equal_in_any_order(dolly):
    whole = {frame: hidden(source(dolly).read(path_of(dolly, frame))) for frame in ALL}
    backwards = source(dolly).read
    assert {it: hidden(backwards(path_of(dolly, it))) for it in reversed(ALL)} == whole


def test_each_plate_is_read_once_and_the_memory_is_bounded(dolly, monkeypatch):
    read, real = [], sequence_reader.read_plate

    def counted(path, options=None):
        read.append(path.name)
        return real(path, options)

    monkeypatch.setattr(sequence_reader, "read_plate", counted)
    plates = NeighbourReader(PlateOptions(), find_sequence(dolly))
    for frame in ALL:
        plates(path_of(dolly, frame))
    assert sorted(read) == sorted(set(read))
    monkeypatch.setattr(sequence_reader, "_SHELF_BYTES", 2 * plate_bytes(real(path_of(dolly, 1))))
    small = NeighbourReader(PlateOptions(), find_sequence(dolly))
    for frame in ALL:
        small(path_of(dolly, frame))
        assert small._shelf.held.bytes_in_use <= sequence_reader._SHELF_BYTES


def test_a_frame_that_is_written_again_is_read_again(tmp_path):
    pattern = write_dolly(tmp_path)
    plates = NeighbourReader(PlateOptions(), find_sequence(pattern))
    before = plates.alone(path_of(pattern, 4))
    assert plates.alone(path_of(pattern, 4)) is before
    shutil.copy(path_of(pattern, 5), path_of(pattern, 4))
    assert plates.alone(path_of(pattern, 4)).color.tobytes() != before.color.tobytes()


def test_a_damaged_neighbour_is_named_and_the_others_serve(tmp_path):
    pattern = write_dolly(tmp_path)
    data = path_of(pattern, 5).read_bytes()
    path_of(pattern, 5).write_bytes(data[: len(data) // 2])
    plates = NeighbourReader(PlateOptions(), find_sequence(pattern))
    found = plates.found(plates.alone(path_of(pattern, 4)))
    assert found.frames and 5 not in found.frames
    (note,) = (note for note in found.plate.notes if "Frame 5 is not used" in note)
    assert "dolly.0005.exr" in note


def test_a_named_frame_takes_them_from_its_sequence_only_if_asked(dolly, tmp_path, capsys):
    frame, shared = path_of(dolly, 4), ("render", path_of(dolly, 4), *LENS)
    said = stderr_of_run(capsys, 0, *shared, "-o", tmp_path / "with.exr", "--neighbours", "2")
    assert "2 frames on either side" in said and "show" in said
    said = stderr_of_run(capsys, 0, *shared, "-o", tmp_path / "alone.exr")
    assert "neighbour" not in said.lower()
    stderr_of_run(capsys, 0, *shared, "-o", tmp_path / "off.exr", "--neighbours", "0")
    pictures = {
        name: read_plate(tmp_path / f"{name}.exr", PlateOptions(depth_source=str(frame))).color
        for name in ("with", "alone", "off")
    }
    assert np.array_equal(pictures["alone"], pictures["off"])
    assert not np.array_equal(pictures["with"], pictures["off"])


def test_what_was_found_can_be_written_and_read_as_pictures_behind(dolly, tmp_path, capsys):
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
    ("words", "told"),
    [
        (("--behind-out", "clean.exr"), "add --neighbours"),
        (("--neighbours", "2", "--behind-out", "clean.png"), "EXR"),
        (("--neighbours", "-1"), "0 to 64"),
    ],
)
def test_what_cannot_be_written_is_refused(dolly, tmp_path, capsys, words, told):
    shared = ("render", path_of(dolly, 4), "-o", tmp_path / "o.exr", *LENS)
    assert told in stderr_of_run(capsys, 2, *shared, *words)
    assert not (tmp_path / "o.exr").exists()


def test_nothing_hidden_is_no_picture(tmp_path, capsys):
    still = path_of(write_dolly(tmp_path, moves=False), 4)
    words = ("--neighbours", "2", "--behind-out", tmp_path / "clean.exr")
    said = stderr_of_run(capsys, 2, "render", still, "-o", tmp_path / "o.exr", *LENS, *words)
    assert "clean.exr" in said and not (tmp_path / "clean.exr").exists()


def test_info_tells_which_neighbours_are_used_and_what_they_show(dolly, untold, capsys):
    assert main(["info", dolly, "--json"]) == 0
    near = json.loads(capsys.readouterr().out)["neighbours"]
    assert near["count"] == 2 and near["step"] >= 1 and 0.1 < near["found"] <= 1
    assert main(["info", dolly]) == 0
    assert "2 frames on either side" in capsys.readouterr().out
    assert main(["info", untold]) == 0
    assert "either side" not in capsys.readouterr().out


def test_a_damaged_first_frame_does_not_keep_the_others_from_it(tmp_path):
    pattern = write_dolly(tmp_path)
    path_of(pattern, FIRST).write_bytes(b"damaged")
    assert hidden(source(pattern).read(path_of(pattern, 4))) is not None


def test_an_export_in_parts_is_the_export_as_a_whole(dolly, tmp_path, capsys):
    words = ("export", dolly, *LENS)
    assert main([*words, "-o", str(tmp_path / "whole.####.exr"), "--frames", "3-5"]) == 0
    for part in ("3", "4-5"):
        assert main([*words, "-o", str(tmp_path / "parts.####.exr"), "--frames", part]) == 0
    for frame in (3, 4, 5):
        whole, part = (tmp_path / f"{it}.{frame:04d}.exr" for it in ("whole", "parts"))
        depth = PlateOptions(depth_source=str(path_of(dolly, frame)))
        assert np.array_equal(read_plate(whole, depth).color, read_plate(part, depth).color)
    capsys.readouterr()


def test_python_takes_them_as_the_command_does(dolly):
    values = {"focal_length_mm": 120, "sensor_width_mm": 36, "f_stop": 1.4, "focus_distance_m": 9}
    with heatlens.open(dolly) as usual, heatlens.open(dolly, neighbours=0) as none:
        pictures = [it.render(frame=4, **values) for it in (usual, none)]
    assert not np.array_equal(*pictures)
