"""Test images of what lies behind a plate, from files and from parts and layers of the plate."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.frame_cache.sequence_reader import SequenceReader, fix_conventions
from heatlens.media.plate.read import read_plate
from support.exr_files import rgb, window, write_file, write_parts

SIZE = (6, 8)


def depth(metres: float) -> np.ndarray:
    return np.full(SIZE, metres, np.float32)


def layer(metres: float, light: float, prefix: str = "") -> dict[str, np.ndarray]:
    color = {prefix + name: np.full(SIZE, light, np.float16) for name in "RGB"}
    return color | {f"{prefix}Z": depth(metres)}


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", rgb() | {"Z": depth(2)})


def lists_of_plate(plate) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances and red values of a plate's only list per pixel, as (48, n)."""
    lists = plate.fragments
    assert lists is not None and set(np.diff(lists.starts.astype(np.int64))) == {
        2 * lists.count // 48
    }
    return (1 / lists.dioptres).reshape(48, -1), lists.color[:, 0].reshape(48, -1)


def test_read_plate_sorts_files_behind_by_depth(tmp_path, plate):
    wall = write_file(tmp_path / "wall.exr", layer(9, 0.5))
    tree = write_file(tmp_path / "tree.exr", layer(4, 0.25))
    plate_with_lists = read_plate(plate, PlateOptions(behind=(str(wall), str(tree))))
    distances, red = lists_of_plate(plate_with_lists)
    assert np.allclose(distances, [4, 9]) and np.allclose(red, [0.25, 0.5])
    flat = read_plate(plate)
    assert np.array_equal(plate_with_lists.color, flat.color) and np.array_equal(
        plate_with_lists.depth_m, flat.depth_m
    )
    notes = " ".join(plate_with_lists.notes)
    assert f"{wall} lies behind 100 %" in notes


def test_read_plate_takes_parts_named_behind(tmp_path):
    path = write_parts(
        tmp_path / "parts.exr",
        ({"name": "front"}, rgb() | {"Z": depth(2)}),
        ({"name": "behind.1"}, layer(4, 0.25)),
        ({"name": "behind.2"}, layer(9, 0.5)),
    )
    distances, red = lists_of_plate(read_plate(path))
    assert np.allclose(distances, [4, 9]) and np.allclose(red, [0.25, 0.5])


def test_read_plate_takes_layers_named_behind(tmp_path):
    channels = rgb() | {"Z": depth(2)} | layer(4, 0.25, "behind.")
    distances, red = lists_of_plate(read_plate(write_file(tmp_path / "layers.exr", channels)))
    assert np.allclose(distances, 4) and np.allclose(red, 0.25)


def test_read_plate_puts_nearer_behind_image_in_front(tmp_path, plate):
    near = write_file(tmp_path / "near.exr", layer(1, 0.75))
    plate_with_lists = read_plate(plate, PlateOptions(behind=(str(near),)))
    assert np.allclose(plate_with_lists.color[..., 0], 0.75) and np.allclose(
        plate_with_lists.depth_m, 1
    )
    assert np.allclose(lists_of_plate(plate_with_lists)[0], 2)


def test_read_plate_places_smaller_data_window_behind(tmp_path, plate):
    small = {name: values[:2, :3] for name, values in layer(4, 0.25).items()}
    wide = {"dataWindow": window(1, 2, 4, 4), "displayWindow": window(0, 0, 8, 6)}
    behind = write_file(tmp_path / "small.exr", small, **wide)
    plate_with_lists = read_plate(plate, PlateOptions(behind=(str(behind),)))
    counts = np.diff(plate_with_lists.fragments.begins).reshape(SIZE)
    assert counts.sum() == 6 and counts[2:4, 1:4].all()


def test_read_plate_rejects_behind_image_with_other_display_window(tmp_path, plate):
    other = write_file(tmp_path / "other.exr", layer(4, 0.25), displayWindow=window(0, 0, 16, 12))
    pattern = r"other\.exr does not show the same view as .*plate\.exr.*16x12"
    with pytest.raises(InputError, match=pattern):
        read_plate(plate, PlateOptions(behind=(str(other),)))


def test_read_plate_uses_frame_number_in_pattern_of_behind(tmp_path):
    for frame in (1, 2):
        write_file(tmp_path / f"plate.{frame:04d}.exr", rgb() | {"Z": depth(2)})
        write_file(tmp_path / f"clean.{frame:04d}.exr", layer(3 + frame, 0.25))
    options = PlateOptions(behind=(str(tmp_path / "clean.####.exr"),))
    plate_with_lists = read_plate(tmp_path / "plate.0002.exr", options)
    assert np.allclose(lists_of_plate(plate_with_lists)[0], 5)
    (tmp_path / "clean.0001.exr").unlink()
    with pytest.raises(InputError, match=r"clean\.0001\.exr is missing"):
        read_plate(tmp_path / "plate.0001.exr", options)


def test_shot_file_stores_behind_paths_relative_to_itself(tmp_path):
    behind = (str(tmp_path / "clean.exr"), str(tmp_path / "wall.exr"))
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), plate_options=PlateOptions(behind=behind))
    path = tmp_path / "s.heatlens.json"
    write_shot(path, shot)
    assert '"clean.exr"' in path.read_text()
    assert read_shot(path).plate_options.behind == behind


def test_render_names_missing_behind_file(tmp_path, plate, capsys):
    out = tmp_path / "o.exr"
    words = ("render", str(plate), "-o", str(out), "--behind", str(tmp_path / "nowhere.exr"))
    lens = ("--f-stop", "2", "--focal-length", "50", "--sensor-width", "36")
    assert main([*words, *lens, "--focus-distance", "2"]) == 2
    assert "nowhere.exr is not there" in capsys.readouterr().err and not out.exists()


def test_info_reports_what_each_behind_image_adds(tmp_path, plate, capsys):
    wall = write_file(tmp_path / "wall.exr", layer(9, 0.5))
    assert main(["info", str(plate), "--behind", str(wall), "--behind", str(plate)]) == 0
    stdout = capsys.readouterr().out
    assert (
        f"{wall} lies behind 100 % of the picture" in stdout and f"{plate} adds nothing" in stdout
    )
    assert main(["info", str(plate), "--behind", str(tmp_path / "nowhere.exr")]) == 2


def test_info_of_sequence_reports_mean_share_of_behind_images(tmp_path, capsys):
    for frame, size in ((1, 8), (2, 4)):
        write_file(tmp_path / f"plate.{frame:04d}.exr", rgb() | {"Z": depth(2)})
        part = {name: values[:, :size] for name, values in layer(9, 0.5).items()}
        ends = {"dataWindow": window(0, 0, size, 6), "displayWindow": window(0, 0, 8, 6)}
        write_file(tmp_path / f"clean.{frame:04d}.exr", part, **ends)
    clean = str(tmp_path / "clean.####.exr")
    assert main(["info", str(tmp_path / "plate.####.exr"), "--behind", clean]) == 0
    assert f"{clean} lies behind 75 % of the picture" in capsys.readouterr().out


def test_sequence_reader_keeps_depth_convention_of_each_file(tmp_path):
    """The plates hold 1/z, the pictures behind meters; both conventions hold for all frames."""
    for frame in (1, 2):
        inverse = np.full(SIZE, 0.5, np.float32)
        inverse[0, 0] = 0.0
        names = rgb() | {"inverse_depth.Z": inverse}
        write_file(tmp_path / f"plate.{frame:04d}.exr", names)
        write_file(tmp_path / f"clean.{frame:04d}.exr", layer(9, 0.25))
    options = PlateOptions(
        behind=(str(tmp_path / "clean.####.exr"),), depth_source=str(tmp_path / "plate.####.exr")
    )
    reader = SequenceReader(options)
    plates = [reader(tmp_path / f"plate.{frame:04d}.exr") for frame in (1, 2)]
    for plate in plates:
        assert plate.depth.convention == "inverse" and np.allclose(plate.depth_m[1:], 2)
        sky, *clean = plate.fragments.dioptres
        assert sky == 0 and np.allclose(clean, 1 / 9)
    settled = fix_conventions(options, plates[0])
    assert settled.behind_conventions == ("distance",)
    read_again = read_plate(tmp_path / "plate.0002.exr", settled)
    assert np.array_equal(read_again.fragments.words, plates[1].fragments.words)


def test_read_plate_explains_behind_image_without_depth(tmp_path, plate):
    flat = write_file(tmp_path / "flat.exr", rgb())
    with pytest.raises(InputError, match=r"flat\.exr has no depth.*render Z into it"):
        read_plate(plate, PlateOptions(behind=(str(flat),)))
