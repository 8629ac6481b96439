"""What a folder holds for a person who looks for pictures."""

import os
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.sequence.folder_list import list_folder, natural
from heatlens.media.sequence.sequence import find_sequence

EXR = (".exr",)


def made(folder, *names):
    for name in names:
        (folder / name).write_bytes(b"")


def names(listing):
    return [entry.name for entry in listing.entries]


def test_sequences_are_one_entry_with_their_frames(tmp_path):
    made(tmp_path, *(f"shot.{n}.exr" for n in (1001, 1002, 1005)), "still.exr", "lone.0007.exr")
    listing = list_folder(tmp_path, EXR)
    assert names(listing) == ["lone.0007.exr", "shot.####.exr", "still.exr"]
    lone, shot, still = listing.entries
    assert (lone.sequence, still.sequence) == (None, None)
    assert (lone.path, still.frames_text) == (tmp_path / "lone.0007.exr", "")
    assert shot.path == tmp_path / "shot.####.exr"
    assert shot.frames_text == "1001-1005, 2 missing"
    assert [shot.file_at(n).name for n in (1, 1003, 1005)] == [
        "shot.1001.exr",
        "shot.1002.exr",
        "shot.1005.exr",
    ]


def test_hidden_files_and_other_kinds_are_left_out(tmp_path):
    made(tmp_path, ".hidden.exr", "._shot.1001.exr", "notes.txt", "UPPER.EXR", "a.png")
    (tmp_path / ".git").mkdir()
    assert names(list_folder(tmp_path, EXR)) == ["UPPER.EXR"]
    assert names(list_folder(tmp_path, (".exr", ".png"))) == ["a.png", "UPPER.EXR"]
    assert list_folder(tmp_path, EXR).folders == ()


def test_folders_are_folders_whatever_they_are_called(tmp_path):
    for name in ("v10", "v9", "take.exr"):
        (tmp_path / name).mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "v9")
    (tmp_path / "nowhere").symlink_to(tmp_path / "gone")
    (tmp_path / "endless").symlink_to(tmp_path / "endless")
    listing = list_folder(tmp_path, EXR)
    assert listing.folders == ("link", "take.exr", "v9", "v10") and listing.entries == ()


def test_a_sequence_whose_name_holds_a_notation_is_opened_by_a_file(tmp_path):
    made(tmp_path, "a#b.1.exr", "a#b.2.exr")
    (entry,) = list_folder(tmp_path, EXR).entries
    assert entry.path.name == "a#b.1.exr"


def test_the_time_is_that_of_the_last_frame(tmp_path):
    made(tmp_path, "s.1.exr", "s.2.exr")
    os.utime(tmp_path / "s.1.exr", (900, 900))
    os.utime(tmp_path / "s.2.exr", (500, 500))
    assert list_folder(tmp_path, EXR).entries[0].written_s == 500


def test_what_is_no_folder_is_told(tmp_path):
    made(tmp_path, "a.exr")
    for path in (tmp_path / "gone", tmp_path / "a.exr"):
        with pytest.raises(InputError, match=f"{path.name} cannot be read"):
            list_folder(path, EXR)


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="all may be read")
def test_a_folder_that_may_not_be_read_is_told(tmp_path):
    tmp_path.chmod(0)
    try:
        with pytest.raises(InputError, match="cannot be read: Permission denied"):
            list_folder(tmp_path, EXR)
    finally:
        tmp_path.chmod(0o700)


@given(st.lists(st.text(), max_size=8))
def test_any_names_have_an_order(texts):
    """Whatever stands in them can be compared, and their order in the folder does not count."""
    ordered = [natural(text) for text in sorted(texts, key=natural)]
    assert ordered == [natural(text) for text in sorted(reversed(texts), key=natural)]


def test_numbers_count_as_numbers():
    assert natural("Shot9") < natural("shot10") < natural("shot10b")


def test_two_sizes_of_a_picture_are_two_pictures(tmp_path):
    made(tmp_path, "hero720.exr", "hero1080.exr", "take1.exr", "take2.exr", "old.0001.exr")
    made(tmp_path, "old.0999.exr")
    assert names(list_folder(tmp_path, EXR)) == [
        "hero720.exr",
        "hero1080.exr",
        "old.####.exr",
        "take#.exr",
    ]


def test_files_of_a_sequence_can_be_listed_and_opened_one_by_one(tmp_path):
    made(tmp_path, "shot.1001.exr", "shot.1002.exr", "take7.exr", "take8.exr", "still.exr")
    listing = list_folder(tmp_path, EXR, is_single=True)
    assert names(listing) == sorted(entry.name for entry in tmp_path.iterdir())
    for entry in listing.entries:
        found = find_sequence(entry.path)
        assert found.is_single and found.path_at(found.first).name == entry.name


def test_a_file_that_is_no_frame_opens_alone(tmp_path):
    made(tmp_path, "hero720.exr", "hero1080.exr", "take1.exr", "take2.exr")
    assert find_sequence(tmp_path / "hero720.exr").is_single
    assert find_sequence(tmp_path / "take1.exr").present == (1, 2)
    assert find_sequence(tmp_path / "hero#.exr").present == (720, 1080)  # named as a sequence
