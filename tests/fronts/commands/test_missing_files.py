"""Test messages about missing files, and about sequences where one frame is needed."""

import pytest

from heatlens.core.base.paths import unreadable_error
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels, message_of_refusal
from support.exr_files import write_file


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
def test_commands_report_missing_file_with_same_message(capsys, tmp_path, monkeypatch, words, name):
    monkeypatch.chdir(tmp_path)
    assert message_of_refusal(capsys, *words) == f"heatlens: {name} is not there.\n"


def test_unreadable_error_explains_folder_and_denied_file(tmp_path):
    assert str(unreadable_error(tmp_path)).startswith(f"{tmp_path} is a folder")
    (tmp_path / "a").touch()
    denied = PermissionError(13, "Permission denied")
    assert str(unreadable_error(tmp_path / "a", denied)).endswith(
        "a cannot be read: Permission denied."
    )


@pytest.mark.parametrize("command", ["render", "study"])
@pytest.mark.parametrize("name", ["seq.####.exr", "seq.%04d.exr", "."])
def test_render_and_study_reject_sequence_in_place_of_frame(
    capsys, tmp_path, monkeypatch, command, name
):
    monkeypatch.chdir(tmp_path)
    for frame in (1, 2):
        write_file(tmp_path / f"seq.{frame:04}.exr", channels(), **CAMERA)
    message = message_of_refusal(capsys, command, name, "-o", tmp_path / "o.exr")
    assert "use `heatlens export` to render the frames" in message and "name one frame" in message
    assert ("is a folder" if name == "." else "is a sequence") in message


def test_info_accepts_single_frame_of_sequence(capsys, tmp_path):
    plate = write_file(tmp_path / "seq.0001.exr", channels(), **CAMERA)
    assert main(["info", str(plate)]) == 0
