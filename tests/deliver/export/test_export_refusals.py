"""Test that impossible exports are refused with a message before anything is written."""

import pytest

from support.exports import files_in, refused_export_message


@pytest.mark.parametrize(
    ("name", "words", "expected"),
    [
        ("n.exr", (), "n.####.exr"),
        ("n.####.gif", (), ".exr, .png"),
        ("n.####.tif", ("--keep-channels", "all"), "only EXR frames hold this"),
        ("n.####.exr", ("--keep-channels", "albedo"), "no layer or channel 'albedo' to keep"),
        ("n.####.exr", ("--keep-channels", "Z", "--proxy", "0.5"), "leave --proxy out"),
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
        ("n.####.exr", ("--start-timecode", "ten"), "not a timecode"),
        ("n.####.exr", ("--start-timecode", "10:00:00;00"), "not at 24 frames a second: write 10"),
        ("n.####.exr", ("--start-timecode", "10:00:00:24"), "frames go from 00 to 23"),
        ("n.####.png", ("--start-timecode", "10:00:00:00"), ".png cannot hold a timecode"),
        ("n.####.exr", ("--proxy", "2"), "proxy"),
        ("n.####.exr", ("--chunk", "2"), "--submit"),
        ("n.####.exr", ("--plate", "nix.####.exr"), "nix.####.exr"),
        ("plates/plate.####.exr", (), "an input of"),
    ],
)
def test_export_rejects_impossible_options_and_writes_nothing(
    capsys, shot_file, tmp_path, name, words, expected
):
    files_before = files_in(tmp_path), files_in(tmp_path / "plates")
    assert expected in refused_export_message(capsys, shot_file, tmp_path / name, *words)
    assert (files_in(tmp_path), files_in(tmp_path / "plates")) == files_before


def test_export_rejects_shot_with_impossible_f_stop(capsys, shot_file, out):
    text = shot_file.read_text().replace('"f_stop": 1.4', '"f_stop": -1')
    shot_file.write_text(text)
    assert "f-stop" in refused_export_message(capsys, shot_file, out)


def test_export_refuses_folder_in_place_of_frame(capsys, shot_file, out):
    (out.parent / "n.1002.exr").mkdir(parents=True)
    message = refused_export_message(capsys, shot_file, out)
    assert "n.1002.exr" in message and "folder" in message
