"""Test the mark of blurred pictures in their files, which warns before a second blur."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from heatlens.deliver.export.finished import fingerprint_in
from heatlens.fronts.commands.main import main
from heatlens.media.files.marks import BLURRED_ATTRIBUTE, JOB_ATTRIBUTE, parse_marks
from heatlens.media.plate.parts.header_read import is_marked_blurred, read_headers
from support.command_line import render
from support.exports import export_shot, write_plate, write_plates, write_shot_file
from support.exports import refused_export_message as export_refused
from support.exr_files import write_file

LENS = ("--f-stop", "2", "--focus-distance", "2.24")
SCENE = Path(__file__).parents[3] / "assets" / "demo.glb"
ENDINGS = (".exr", ".png", ".jpg", ".tif", ".webp", ".dpx")


def info_of(capsys, *words: object) -> dict:
    assert main(["info", "--json", *map(str, words)]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("command", ["render", "export"])
def test_rendered_picture_is_marked_blurred_and_info_reports_it(capsys, tmp_path, command, ending):
    source = write_plates(tmp_path / "in", (1001,))
    out = tmp_path / "out" / f"n.####{ending}"
    if command == "export":
        export_shot(capsys, source, out, *LENS, "--quality", "draft")
        output = out.with_name(f"n.1001{ending}")
    else:
        output = out.with_name(f"n.1001{ending}")
        render(capsys, source.replace("####", "1001"), output, *LENS, "--quality", "draft")
    assert is_marked_blurred(output)
    facts = info_of(capsys, output)
    assert facts["is_blurred"] and "already blurred" in " ".join(facts["notes"])
    assert not info_of(capsys, source.replace("####", "1001"))["is_blurred"]


@pytest.mark.parametrize("name", ["m.mov", "m.mp4"])
def test_exported_movie_is_marked_blurred(capsys, tmp_path, name):
    source = write_plates(tmp_path / "in", (1001, 1002))
    export_shot(capsys, source, tmp_path / name, *LENS, "--quality", "draft")
    assert is_marked_blurred(tmp_path / name)
    assert fingerprint_in(tmp_path / name)


def test_pinhole_output_is_marked_not_blurred(capsys, tmp_path):
    size = ("--size", "32x18", "--pinhole")
    assert main(["render", str(SCENE), "-o", str(tmp_path / "a.exr"), *size]) == 0
    out = str(tmp_path / "n.####.exr")
    assert main(["export", str(SCENE), "-o", out, "--frames", "1", *size]) == 0
    capsys.readouterr()
    for output in (tmp_path / "a.exr", *tmp_path.glob("n.*.exr")):
        assert read_headers(output)[0][BLURRED_ATTRIBUTE] == "no"
        facts = info_of(capsys, output)
        assert not facts["is_blurred"] and "blurred" not in " ".join(facts["notes"])


def test_render_of_blurred_plate_warns_and_strict_refuses(capsys, tmp_path):
    write_plate(tmp_path / "p.exr")
    depth = ("--keep-channels", "Z")
    render(capsys, tmp_path / "p.exr", tmp_path / "a.exr", *LENS, *depth, "--quality", "draft")
    message = render(capsys, tmp_path / "a.exr", tmp_path / "b.exr", *LENS, "--quality", "draft")
    assert f"{tmp_path / 'a.exr'} is already blurred" in message
    strict = ["render", str(tmp_path / "a.exr"), "-o", str(tmp_path / "c.exr"), *LENS, "--strict"]
    assert main(strict) == 2
    assert "already blurred" in capsys.readouterr().err
    assert not (tmp_path / "c.exr").exists()


def test_export_of_blurred_frames_warns(capsys, tmp_path):
    shot = write_shot_file(tmp_path)
    export_shot(capsys, shot, tmp_path / "once" / "n.####.exr", "--with-depth", "--frames", "1001")
    shot_json = json.loads(shot.read_text())
    shot_json["source"] = "once/n.####.exr"
    shot.write_text(json.dumps(shot_json))
    words = ("--frames", "1001")
    assert "already blurred" in export_shot(capsys, shot, tmp_path / "twice.####.exr", *words)


@pytest.mark.parametrize("ending", [".exr", ".png", ".jpg"])
def test_info_notes_export_of_older_version_without_refusing(capsys, tmp_path, ending):
    file, mark = tmp_path / f"old{ending}", "0123abcd"
    image = Image.new("RGB", (8, 6))
    if ending == ".exr":
        write_file(file, {n: np.ones((6, 8), np.float32) for n in "RGBZ"}, **{JOB_ATTRIBUTE: mark})
    elif ending == ".png":
        text = PngInfo()
        text.add_text(JOB_ATTRIBUTE, mark)
        image.save(file, pnginfo=text)
    else:
        image.save(file, comment=f"{JOB_ATTRIBUTE}={mark}")
    assert fingerprint_in(file) == mark
    facts = info_of(capsys, file, "--strict")
    assert not facts["is_blurred"] and "older heatlens" in " ".join(facts["notes"])


def test_parse_marks_ignores_foreign_comments():
    assert parse_marks("made by a=b heatlens:jobs=3 heatlens") == {}
    assert parse_marks(None) == {}


# Edits


def edit_of(folder: Path) -> Path:
    """Write an EDL with two frames of the clip sh01 and without file names. Return its path."""
    path = folder / "cut.edl"
    path.write_text(
        "TITLE: cut\nFCM: NON-DROP FRAME\n"
        "001  AX V C 00:00:41:17 00:00:41:19 00:00:00:00 00:00:00:02\n"
        "* FROM CLIP NAME: sh01\n"
    )
    return path


def export_cut(cut: Path, out: Path, *words: object) -> None:
    blur_options = (*LENS, "--quality", "draft", "--with-depth")
    assert main(["export", str(cut), "-o", str(out), *map(str, words), *blur_options]) == 0


def write_clip(folder: Path) -> None:
    folder.mkdir(parents=True)
    for frame in (1001, 1002):
        write_plate(folder / f"sh01.{frame}.exr", frame)


def test_edit_prefers_unblurred_plates_to_its_own_export(capsys, tmp_path):
    cut = edit_of(tmp_path)
    write_clip(tmp_path / "plates" / "sh01")
    export_pattern = tmp_path / "aa" / "{shot}" / "{shot}.####.exr"
    media = ("--media", tmp_path)
    export_cut(cut, export_pattern, *media)
    capsys.readouterr()
    facts = info_of(capsys, cut, *media)
    (shot,) = facts["shots"]
    assert shot["source"] == str(tmp_path / "plates" / "sh01" / "sh01.####.exr")
    (note,) = (it for it in shot["notes"] if "media fit" in it)
    assert str(tmp_path / "aa" / "sh01" / "sh01.####.exr") in note and "already blurred" in note


def test_export_and_reel_refuse_edit_of_blurred_media(capsys, tmp_path):
    cut = edit_of(tmp_path)
    write_clip(tmp_path / "plates" / "sh01")
    out = tmp_path / "out" / "{shot}" / "{shot}.####.exr"
    export_cut(cut, out, "--media", tmp_path / "plates")
    capsys.readouterr()
    only = ("--media", str(tmp_path / "out"))
    message = export_refused(capsys, cut, tmp_path / "b" / "{shot}.####.exr", *only, *LENS)
    assert "sh01" in message and "already blurred" in message and not (tmp_path / "b").exists()
    assert main(["reel", str(cut), "-o", str(tmp_path / "r.heatreel.json"), *only]) == 2
    assert "already blurred" in capsys.readouterr().err
    assert "already blurred" in " ".join(info_of(capsys, cut, *only)["shots"][0]["notes"])
