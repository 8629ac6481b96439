"""A file that is not there is told of in one way; many frames, where one is wanted, in another."""

import pytest

from heatlens.core.base.paths import unreadable
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels
from support.exr_files import write_file


def refused(capsys, *words: object) -> str:
    assert main([str(word) for word in words]) == 2
    said = capsys.readouterr()
    assert said.out == "" and len(said.err.splitlines()) == 1
    return said.err


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("render", "gone.exr", "-o", "o.exr"), "gone.exr"),
        (("render", "gone.glb", "-o", "o.exr"), "gone.glb"),
        (("render", "gone.obj", "-o", "o.exr"), "gone.obj"),
        (("info", "gone.exr"), "gone.exr"),
        (("info", "gone.gltf"), "gone.gltf"),
        (("compare", "gone.exr", "gone.exr"), "gone.exr"),
        (("export", "gone.heatlens.json", "-o", "o.exr"), "gone.heatlens.json"),
        (("export", "gone.glb", "-o", "o.exr", "--f-stop", "2"), "gone.glb"),
        (("shot", "show", "gone.heatlens.json"), "gone.heatlens.json"),
        (("camera", "gone.csv", "-o", "c.nk"), "gone.csv"),
        (("camera", "gone.usda", "-o", "c.nk"), "gone.usda"),
        (("view", "gone.glb"), "gone.glb"),
    ],
)
def test_a_missing_file_is_said_in_one_way(capsys, tmp_path, monkeypatch, words, name):
    monkeypatch.chdir(tmp_path)
    assert refused(capsys, *words) == f"heatlens: {name} is not there.\n"


def test_a_folder_and_what_may_not_be_read(tmp_path):
    assert str(unreadable(tmp_path)).startswith(f"{tmp_path} is a folder")
    (tmp_path / "a").touch()
    denied = PermissionError(13, "Permission denied")
    assert str(unreadable(tmp_path / "a", denied)).endswith("a cannot be read: Permission denied.")


@pytest.mark.parametrize("command", ["render", "study"])
@pytest.mark.parametrize("name", ["seq.####.exr", "seq.%04d.exr", "."])
def test_a_sequence_where_one_frame_is_wanted(capsys, tmp_path, monkeypatch, command, name):
    monkeypatch.chdir(tmp_path)
    for frame in (1, 2):
        write_file(tmp_path / f"seq.{frame:04}.exr", channels(), **CAMERA)
    said = refused(capsys, command, name, "-o", tmp_path / "o.exr")
    assert "use `heatlens export` to render the frames" in said and "name one frame" in said
    assert ("is a folder" if name == "." else "is a sequence") in said


def test_one_of_its_frames_is_no_sequence(capsys, tmp_path):
    plate = write_file(tmp_path / "seq.0001.exr", channels(), **CAMERA)
    assert main(["info", str(plate)]) == 0
