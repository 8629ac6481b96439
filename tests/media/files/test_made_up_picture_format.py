"""A format of pictures is one record: one that a test makes up works everywhere, without more.

Its files are NumPy's text of numbers between two lines. The record is all that heatlens learns of
it: it is offered, explained, written, known again when it was cut short or belongs to others, and
refused in words for names of no format.
"""

from io import StringIO

import numpy as np
import pytest

from heatlens.deliver.export.finished import fingerprint_in, is_complete
from heatlens.fronts.commands.main import main
from heatlens.media.files.foreign_formats import describe_other_format
from heatlens.media.files.marks import marks_comment, parse_marks
from heatlens.media.files.picture_formats import FORMATS, PictureFormat, Writing, is_picture
from heatlens.studio.settings.export_settings import ExportSettings, frame_kinds
from heatlens.studio.settings.file_purposes import PURPOSES
from support.command_line import refused_render_message as render_refused
from support.command_line import render, stderr_of_run
from support.exports import (
    FRAMES,
    HEIGHT,
    WIDTH,
    export_and_list_new_frames,
    export_shot,
    files_in,
    names_of,
    refused_export_message,
    write_plate,
    write_shot_file,
)

_END = b"the end\n"
SHOWN = ("--view", "sRGB curve")


def text_of(values, marks) -> bytes:
    """Return lines of all numbers, after the marks in the first line."""
    lines = StringIO()
    np.savetxt(lines, values.reshape(-1, values.shape[2]), "%d", header=marks_comment(marks))
    return f"NUMBERS\n{lines.getvalue()}".encode() + _END


def marks_of(path) -> dict[str, str]:
    first, second, *_ = path.read_bytes().split(b"\n")
    if first != b"NUMBERS":
        raise ValueError(f"{path} holds no numbers")
    return parse_marks(second.removeprefix(b"# "))


def ends(file, size: int) -> bool:
    file.seek(size - len(_END))
    return file.read() == _END


MADE_UP = PictureFormat(
    word="Numbers",
    suffixes=(".numbers", ".nums"),
    begins=(b"NUMBERS",),
    writing=Writing(text_of, marks_of, ends, bits=12, most_px=40),
)


@pytest.fixture(autouse=True)
def made_up():
    FORMATS.append(MADE_UP)
    yield
    FORMATS.remove(MADE_UP)


@pytest.fixture
def shot_file(tmp_path):
    folder = tmp_path / "shot"
    folder.mkdir()
    return write_shot_file(folder)


def test_render_writes_new_picture_format(capsys, tmp_path):
    write_plate(tmp_path / "p.exr")
    render(capsys, tmp_path / "p.exr", tmp_path / "a.numbers", "--quality", "draft")
    values = np.loadtxt(tmp_path / "a.numbers", skiprows=2, comments=("the", "#"))
    assert values.shape == (WIDTH * HEIGHT, 3) and 255 < values.max() <= 4095


def test_export_recognizes_its_own_frames_of_new_format(capsys, tmp_path, shot_file):
    out = tmp_path / "out" / "n.####.nums"
    export_shot(capsys, shot_file, out, *SHOWN)
    exported_files = files_in(out.parent)
    assert list(exported_files) == names_of(".nums")
    assert export_and_list_new_frames(capsys, shot_file, out, *SHOWN) == []
    cut = out.with_name("n.1003.nums")
    assert fingerprint_in(cut) and is_complete(cut)
    cut.write_bytes(exported_files[cut.name][:-20])
    assert not is_complete(cut) and export_and_list_new_frames(capsys, shot_file, out, *SHOWN) == [
        FRAMES[2]
    ]
    assert files_in(out.parent) == exported_files
    assert export_and_list_new_frames(capsys, shot_file, out, *SHOWN, "--exposure=1") == list(
        FRAMES
    )


def test_export_refuses_to_overwrite_files_of_others(capsys, tmp_path, shot_file):
    out = tmp_path / "out" / "n.####.numbers"
    out.parent.mkdir()
    (out.parent / "n.1002.numbers").write_bytes(b"NUMBERS\n# mine\n" + _END)
    before = files_in(out.parent)
    message = refused_export_message(capsys, shot_file, out, *SHOWN)
    assert "no export wrote it" in message and files_in(out.parent) == before
    assert export_and_list_new_frames(capsys, shot_file, out, *SHOWN, "--overwrite") == list(FRAMES)


@pytest.mark.parametrize("command", ["render", "export"])
def test_help_lists_new_picture_format(capsys, command):
    with pytest.raises(SystemExit):
        main([command, "--help-all"])
    assert ".numbers (12 bits)" in " ".join(capsys.readouterr().out.split())


def test_window_offers_new_picture_format():
    kind = "Numbers (as displayed)"
    assert list(frame_kinds())[-3:] == [kind, "ProRes movie", "H.264 movie"]
    assert ExportSettings("/a", "b", kind).output == "/a/b.####.numbers"
    assert {".numbers", ".nums"} <= set(PURPOSES["save"].suffixes) & set(PURPOSES["open"].suffixes)


def test_readers_accept_new_format_and_recognize_it_under_other_suffixes(capsys, tmp_path):
    assert is_picture(tmp_path / "a.NUMS")
    assert ".numbers, .nums" in describe_other_format(tmp_path / "a.psd")
    disguised = tmp_path / "p.png"
    disguised.write_bytes(b"NUMBERS\n" + _END)
    message = render_refused(capsys, disguised, tmp_path / "a.exr", "--depth", disguised)
    assert f"{disguised} is Numbers, although its name ends in .png: rename it to p.numb" in message


def test_refusal_of_other_suffixes_lists_all_written_formats(capsys, tmp_path, shot_file):
    write_plate(tmp_path / "p.exr")
    ends = ".exr, .png, .jpg, .jpeg, .tif, .tiff, .webp, .dpx, .numbers, .nums"
    message = render_refused(capsys, tmp_path / "p.exr", tmp_path / "a.bmp")
    assert f"a.bmp: the output must end in {ends}." in message
    message = refused_export_message(capsys, shot_file, tmp_path / "a.####.heic")
    assert f"the output must end in {ends}, .mov, .mp4." in message


def test_render_rejects_picture_larger_than_format_allows(capsys, tmp_path):
    write_plate(tmp_path / "p.exr", size=(48, 27))
    out = tmp_path / "a.numbers"
    message = stderr_of_run(
        capsys, 2, "render", tmp_path / "p.exr", "-o", out, "--quality", "draft"
    )
    assert not out.exists()
    assert "a.numbers: 48 x 27 pixels are too many for this format, which has at most 40" in message
