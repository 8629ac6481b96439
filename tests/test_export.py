"""`heatlens export` to EXR: each frame is what `heatlens render` makes of it, and says its lens."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from exports import (
    FRAMES,
    HEIGHT,
    QUICK,
    WIDTH,
    exported,
    exr,
    files_in,
    names_of,
    refused,
    shot_of,
    with_focus,
    write_plate,
    write_plates,
    write_shot_file,
)
from exr_files import rgb, window, write_file
from heatlens.commands.main import main
from heatlens.image.camera_header import camera_at_header
from heatlens.image.exr_read import read_plate
from heatlens.image.shot_file import read_shot, write_shot
from heatlens.model.coc import coc_line, coc_px
from heatlens.model.frames import FrameRange
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import Bokeh, DefocusSettings, Quality
from heatlens.model.shot import Shot

pytestmark = pytest.mark.usefixtures("command_context")


@pytest.fixture
def shot_file(tmp_path):
    return write_shot_file(tmp_path)


@pytest.fixture
def out(tmp_path):
    """Not there yet: the export makes it."""
    return tmp_path / "out" / "n.####.exr"


def same_frames(a, b) -> bool:
    """Whether two EXR files hold the same pixels."""
    first, second = exr(a)[1], exr(b)[1]
    return first.keys() == second.keys() and all(
        np.array_equal(first[name], second[name]) for name in first
    )


def rendered(capsys, shot: Shot, frame: int, path, *words: str):
    """What `heatlens render` makes of the shot's lens at a frame."""
    lens, defocus = shot.lens_at(frame), shot.defocus
    options = {
        "--focal-length": lens.focal_length_mm,
        "--sensor-width": lens.sensor_width_mm,
        "--f-stop": lens.f_stop,
        "--focus-distance": repr(lens.focus_distance_m),
        "--bokeh": defocus.bokeh,
        "--quality": defocus.quality,
        "--proxy": defocus.proxy,
    }
    plate = shot.source.replace("####", str(frame))
    said = [f"{name}={value}" for name, value in options.items()]
    assert main(["render", plate, "-o", str(path), *said, *words]) == 0
    capsys.readouterr()
    return path


# What is written


def test_every_frame_is_what_render_makes_of_its_plate_and_lens(capsys, shot_file, out, tmp_path):
    exported(capsys, shot_file, out, "--float")
    assert list(files_in(out.parent)) == names_of(".exr")
    shot = read_shot(shot_file)
    for frame in FRAMES:
        alone = rendered(capsys, shot, frame, tmp_path / "alone.exr", "--float")
        assert same_frames(out.parent / f"n.{frame}.exr", alone)
    assert not same_frames(out.parent / "n.1001.exr", out.parent / "n.1002.exr")


def test_discs_at_half_size_as_render_makes_them(capsys, shot_file, out, tmp_path):
    """The blur options count where they are given, and else the shot's."""
    words = ("--bokeh", "disc", "--proxy", "0.5")
    exported(capsys, shot_file, out, *words, "--frames", "1003")
    blur = DefocusSettings(Bokeh.DISC, QUICK.quality, None, 0.5)
    shot = replace(read_shot(shot_file), defocus=blur)
    alone = rendered(capsys, shot, 1003, tmp_path / "alone.exr")
    assert same_frames(out.parent / "n.1003.exr", alone)
    assert exr(alone)[1]["R"].shape == (HEIGHT // 2, WIDTH // 2)


def test_the_header_of_each_frame_tells_the_lens_of_that_frame(capsys, shot_file, out):
    exported(capsys, shot_file, out)
    shot = read_shot(shot_file)
    for frame in FRAMES:
        camera, lens = camera_at_header([exr(out.parent / f"n.{frame}.exr")[0]]), None
        lens = shot.lens_at(frame)
        assert camera.focus_distance_m == pytest.approx(lens.focus_distance_m, rel=1e-6)
        assert camera.f_stop == pytest.approx(lens.f_stop, rel=1e-6)
        assert camera.focal_length_mm == lens.focal_length_mm
        assert camera.sensor_width_mm == lens.sensor_width_mm


def test_windows_and_metadata_of_the_plates_are_kept(capsys, tmp_path, out):
    windows = {"dataWindow": window(-3, 2, 29, 20), "displayWindow": window(0, 0, 28, 24)}
    header = {"owner": "second unit", "pixelAspectRatio": 2.0, "tStop": 2.3, **windows}
    write_shot(tmp_path / "s.heatlens.json", shot_of(write_plates(tmp_path / "plates", **header)))
    exported(capsys, tmp_path / "s.heatlens.json", out)
    found = exr(out.parent / "n.1004.exr")[0]
    assert found["owner"] == "second unit" and found["pixelAspectRatio"] == 2.0
    assert found["tStop"] == pytest.approx(2.3)
    for name, value in windows.items():
        np.testing.assert_array_equal(found[name], value)


@pytest.mark.parametrize("compression", ["none", "zips", "piz"])
def test_compression_and_depth_of_numbers(capsys, shot_file, out, tmp_path, compression):
    exported(capsys, shot_file, out, "--frames", "1001", "--compression", compression)
    header, channels = exr(out.parent / "n.1001.exr")
    said = "NO" if compression == "none" else compression.upper()
    assert str(header["compression"]).endswith(f"{said}_COMPRESSION")
    assert channels["R"].dtype == np.float16 and set(channels) == {"R", "G", "B"}
    exported(capsys, shot_file, tmp_path / "f.exr", "--frames", "1001", "--float")
    assert exr(tmp_path / "f.exr")[1]["R"].dtype == np.float32


@pytest.mark.parametrize("proxy", [1.0, 0.5])
def test_depth_and_coc_beside_the_colour(capsys, shot_file, out, proxy):
    words = ("--with-depth", "--with-coc", "--proxy", proxy, "--frames", "1002")
    exported(capsys, shot_file, out, *words)
    _, channels = exr(out.parent / "n.1002.exr")
    shot = read_shot(shot_file)
    plate = read_plate(shot.source.replace("####", "1002"))
    step = round(1 / proxy)
    depth_m = plate.depth_m[step // 2 :: step, step // 2 :: step]
    coc = proxy * coc_px(depth_m, coc_line(shot.lens_at(1002), WIDTH))
    assert channels["Z"].dtype == channels["coc"].dtype == np.float32
    assert np.array_equal(channels["Z"], depth_m) and np.isinf(depth_m).any()
    np.testing.assert_allclose(channels["coc"], coc, rtol=1e-6)


def test_the_coc_that_is_written_reads_as_the_coc_of_the_lens(capsys, shot_file, out, tmp_path):
    """Sharp pixels stay where they were: in focus at 3 m the sign of coc says near and far."""
    exported(capsys, shot_file, out, "--with-coc", "--frames", "1006")
    plate = read_plate(out.parent / "n.1006.exr", PlateOptions(depth_convention="coc"))
    depth_m = read_plate(tmp_path / "plates" / "plate.1006.exr").depth_m
    assert np.array_equal(plate.coc_px > 0, depth_m > 3.0)


def test_a_plate_of_coc_has_no_depth_to_give(capsys, tmp_path, out):
    coc = np.full((HEIGHT, WIDTH), 4.0, np.float32)
    plate = write_file(tmp_path / "p.exr", rgb(HEIGHT, WIDTH) | {"coc": coc})
    words = ("--depth-convention", "coc", "--bokeh", "heat", "--quality", "draft")
    exported(capsys, plate, out.with_name("n.exr"), *words, "--with-coc")
    assert np.array_equal(exr(out.with_name("n.exr"))[1]["coc"], coc)
    said = refused(capsys, plate, out.with_name("m.exr"), *words, "--with-depth")
    assert "p.exr" in said and "no depth" in said
    assert list(files_in(out.parent)) == ["n.exr"]


# Which frames


@pytest.mark.parametrize(
    ("words", "frames"),
    [
        ((), (1002, 1003, 1004)),
        (("--frames", "1001-1006x2"), (1001, 1003, 1005)),
        (("--frames", "1006,1001"), (1001, 1006)),
    ],
)
def test_frames_from_in_to_out_or_those_that_are_asked_for(
    capsys, tmp_path, shot_file, out, words, frames
):
    write_shot(shot_file, replace(read_shot(shot_file), in_out=FrameRange(1002, 1004)))
    said = exported(capsys, shot_file, out, *words)
    assert list(files_in(out.parent)) == names_of(".exr", frames)
    assert f"{len(frames)} frames written." in said


def test_a_still_is_there_at_every_key_of_its_shot(capsys, tmp_path, out):
    still = write_plate(tmp_path / "still.exr")
    shot = replace(shot_of(str(still)), frames=None)
    write_shot(tmp_path / "s.heatlens.json", shot)
    exported(capsys, tmp_path / "s.heatlens.json", out)
    assert list(files_in(out.parent)) == names_of(".exr")
    assert not same_frames(out.parent / "n.1001.exr", out.parent / "n.1006.exr")


def test_plates_in_the_place_of_a_shot_have_one_lens(capsys, shot_file, out, tmp_path):
    pattern = tmp_path / "plates" / "plate.####.exr"
    words = ("--bokeh", "heat", "--quality", "draft", "--f-stop", "1.4")
    said = exported(capsys, pattern, out, *words, "--frames", "1002-1003")
    assert "f/1.4 (--f-stop)" in said and "focus 2.24 m (header, focus)" in said
    still = replace(read_shot(shot_file).lens, focus_distance_m=float(np.float32(2.24)))
    shot = Shot(still, QUICK, str(pattern))
    for frame in (1002, 1003):
        alone = rendered(capsys, shot, frame, tmp_path / "alone.exr")
        assert same_frames(out.parent / f"n.{frame}.exr", alone)


def test_other_plates_than_the_shots(capsys, shot_file, out, tmp_path):
    (tmp_path / "plates").rename(tmp_path / "moved")
    assert "plates" in refused(capsys, shot_file, out)
    exported(capsys, shot_file, out, "--plate", tmp_path / "moved" / "plate.####.exr")
    assert list(files_in(out.parent)) == names_of(".exr")


def test_frames_may_differ_in_size(capsys, shot_file, out, tmp_path):
    write_plate(tmp_path / "plates" / "plate.1003.exr", size=(20, 30))
    exported(capsys, shot_file, out)
    shapes = [exr(out.parent / name)[1]["R"].shape for name in names_of(".exr")]
    assert shapes == [(HEIGHT, WIDTH)] * 2 + [(30, 20)] + [(HEIGHT, WIDTH)] * 3


# Plates that are missing or damaged


@pytest.fixture
def gappy(shot_file, tmp_path):
    """1003 and 1006 have no plate."""
    for frame in (1003, 1006):
        (tmp_path / "plates" / f"plate.{frame}.exr").unlink()
    return shot_file


def test_missing_plates_stop_an_export_before_it_begins(capsys, gappy, out):
    said = refused(capsys, gappy, out)
    assert "no file for 2 of 6 frames: 1003,1006" in said and "--missing hold" in said
    assert not out.parent.exists()


def test_hold_renders_the_plate_before_through_the_lens_of_the_frame(capsys, gappy, out, tmp_path):
    exported(capsys, gappy, out, "--missing", "hold")
    assert list(files_in(out.parent)) == names_of(".exr")
    shot = replace(read_shot(gappy), source=str(tmp_path / "plates" / "plate.1002.exr"))
    alone = rendered(capsys, shot, 1003, tmp_path / "alone.exr")
    assert same_frames(out.parent / "n.1003.exr", alone)
    assert not same_frames(out.parent / "n.1003.exr", out.parent / "n.1002.exr")


def test_black_is_black_in_the_size_of_the_plates(capsys, gappy, out):
    exported(capsys, gappy, out, "--missing", "black", "--with-depth")
    _, channels = exr(out.parent / "n.1003.exr")
    assert all((channels[name] == 0).all() for name in "RGB")
    assert channels["R"].shape == (HEIGHT, WIDTH) and np.isinf(channels["Z"]).all()
    assert exr(out.parent / "n.1004.exr")[1]["R"].any()


def test_a_damaged_plate_stops_there_and_what_is_done_stays(capsys, shot_file, out, tmp_path):
    plate = tmp_path / "plates" / "plate.1004.exr"
    whole = plate.read_bytes()
    plate.write_bytes(whole[: len(whole) // 2])
    said = refused(capsys, shot_file, out)
    assert "plate.1004.exr" in said and "damaged or cut short" in said
    assert list(files_in(out.parent)) == names_of(".exr", (1001, 1002, 1003))
    plate.write_bytes(whole)
    assert "3 frames written, 3 were finished before." in exported(capsys, shot_file, out)


# What is refused


@pytest.mark.parametrize(
    ("name", "words", "expected"),
    [
        ("n.exr", (), "n.####.exr"),
        ("n.####.tif", (), ".exr, .png"),
        ("n.1001-1003####.exr", (), "--frames"),
        ("n.####.mov", (), "one file"),
        ("no/where/n.####.exr", (), "no folder"),
        ("n.####.exr", ("--burn-in", "--view", "Raw"), "--view, --burn-in"),
        ("n.####.exr", ("--exposure", "1"), "scene-linear"),
        ("n.####.png", ("--with-depth", "--float"), "--float, --with-depth"),
        ("n.####.png", ("--exposure", "nan"), "exposure"),
        ("n.####.exr", ("--f-stop", "2"), "--f-stop"),
        ("n.####.exr", ("--frames", "12-"), "12-"),
        ("n.####.exr", ("--fps", "0"), "Frames per second"),
        ("n.####.exr", ("--proxy", "2"), "proxy"),
        ("n.####.exr", ("--chunk", "2"), "--submit"),
        ("n.####.exr", ("--plate", "nix.####.exr"), "nix.####.exr"),
        ("plates/plate.####.exr", (), "plate itself"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(
    capsys, shot_file, tmp_path, name, words, expected
):
    before = files_in(tmp_path), files_in(tmp_path / "plates")
    assert expected in refused(capsys, shot_file, tmp_path / name, *words)
    assert (files_in(tmp_path), files_in(tmp_path / "plates")) == before


def test_a_lens_that_cannot_be_is_told_with_its_frame(capsys, shot_file, out):
    text = shot_file.read_text().replace('"f_stop": 1.4', '"f_stop": -1')
    shot_file.write_text(text)
    assert "f-stop" in refused(capsys, shot_file, out)


def test_a_folder_in_the_place_of_a_frame(capsys, shot_file, out):
    (out.parent / "n.1002.exr").mkdir(parents=True)
    said = refused(capsys, shot_file, out)
    assert "n.1002.exr" in said and "folder" in said


# What is said


def test_programs_get_a_line_for_each_frame(capsys, shot_file, out):
    assert main(["export", str(shot_file), "-o", str(out), "--frames", "1001-1002"]) == 0
    capsys.readouterr()
    words = ["--frames", "1001-1004", "--progress", "json"]
    assert main(["export", str(shot_file), "-o", str(out), *words]) == 0
    said = capsys.readouterr()
    begin, *frames, end = (json.loads(line) for line in said.out.splitlines())
    assert begin == {"event": "begin", "output": str(out), "frames": 4}
    assert [(f["frame"], f["state"], f["done"]) for f in frames] == [
        (1001, "finished before", 1),
        (1002, "finished before", 2),
        (1003, "written", 3),
        (1004, "written", 4),
    ]
    assert frames[2]["path"] == str(out.parent / "n.1003.exr")
    assert frames[0]["seconds_left"] is None and frames[3]["seconds_left"] == 0
    assert end == {"event": "end", "output": str(out), "written": 2, "finished_before": 2}
    assert said.err == ""


def test_a_farm_is_told_in_its_own_words(capsys, shot_file, out, tmp_path):
    (tmp_path / "plates" / "plate.1002.exr").write_bytes(b"")
    words = ["export", str(shot_file), "-o", str(out), "--progress", "openjd"]
    assert main(words) == 2
    said = capsys.readouterr().out.splitlines()
    assert said[:2] == ["openjd_status: frame 1001, 1 of 6", "openjd_progress: 16.7"]
    assert re.fullmatch(r"openjd_fail: .*plate\.1002\.exr is empty.*", said[2])


def test_a_shot_with_another_key_in_the_middle_exports_that_pull(capsys, shot_file, out):
    write_shot(shot_file, with_focus(read_shot(shot_file), 1003, 5.0))
    exported(capsys, shot_file, out, "--frames", "1003")
    camera = camera_at_header([exr(out.parent / "n.1003.exr")[0]])
    assert camera.focus_distance_m == pytest.approx(5.0)
    assert Quality.DRAFT is read_shot(shot_file).defocus.quality
