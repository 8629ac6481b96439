"""Test the listing of a folder for a user who looks for images."""

import os
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.sequence.folder_list import list_folder, natural_key
from heatlens.media.sequence.sequence_search import find_sequence

EXR = (".exr",)


def make_files(folder, *names):
    for name in names:
        (folder / name).write_bytes(b"")


def entry_names(listing):
    return [entry.name for entry in listing.entries]


def test_list_folder_shows_sequence_as_one_entry_with_frames(tmp_path):
    make_files(
        tmp_path, *(f"shot.{n}.exr" for n in (1001, 1002, 1005)), "still.exr", "lone.0007.exr"
    )
    listing = list_folder(tmp_path, EXR)
    assert entry_names(listing) == ["lone.0007.exr", "shot.####.exr", "still.exr"]
    lone_entry, shot_entry, still_entry = listing.entries
    assert (lone_entry.sequence, still_entry.sequence) == (None, None)
    assert (lone_entry.path, still_entry.frames_text) == (tmp_path / "lone.0007.exr", "")
    assert shot_entry.path == tmp_path / "shot.####.exr"
    assert shot_entry.frames_text == "1001-1005, 2 missing"
    assert [shot_entry.file_at(n).name for n in (1, 1003, 1005)] == [
        "shot.1001.exr",
        "shot.1002.exr",
        "shot.1005.exr",
    ]


def test_list_folder_omits_hidden_files_and_other_suffixes(tmp_path):
    make_files(tmp_path, ".hidden.exr", "._shot.1001.exr", "notes.txt", "UPPER.EXR", "a.png")
    (tmp_path / ".git").mkdir()
    assert entry_names(list_folder(tmp_path, EXR)) == ["UPPER.EXR"]
    assert entry_names(list_folder(tmp_path, (".exr", ".png"))) == ["a.png", "UPPER.EXR"]
    assert list_folder(tmp_path, EXR).folders == ()


def test_list_folder_lists_folders_by_type_not_name(tmp_path):
    for name in ("v10", "v9", "take.exr"):
        (tmp_path / name).mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "v9")
    (tmp_path / "nowhere").symlink_to(tmp_path / "gone")
    (tmp_path / "endless").symlink_to(tmp_path / "endless")
    listing = list_folder(tmp_path, EXR)
    assert listing.folders == ("link", "take.exr", "v9", "v10") and listing.entries == ()


def test_list_folder_opens_sequence_with_marks_in_name_by_a_file(tmp_path):
    make_files(tmp_path, "a#b.1.exr", "a#b.2.exr")
    (entry,) = list_folder(tmp_path, EXR).entries
    assert entry.path.name == "a#b.1.exr"


def test_list_folder_time_of_sequence_is_that_of_last_frame(tmp_path):
    make_files(tmp_path, "s.1.exr", "s.2.exr")
    os.utime(tmp_path / "s.1.exr", (900, 900))
    os.utime(tmp_path / "s.2.exr", (500, 500))
    assert list_folder(tmp_path, EXR).entries[0].written_s == 500


def test_list_folder_reports_path_that_is_no_folder(tmp_path):
    make_files(tmp_path, "a.exr")
    for path in (tmp_path / "gone", tmp_path / "a.exr"):
        with pytest.raises(InputError, match=f"{path.name} cannot be read"):
            list_folder(path, EXR)


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="all may be read")
def test_list_folder_reports_folder_without_permission(tmp_path):
    tmp_path.chmod(0)
    try:
        with pytest.raises(InputError, match="cannot be read: Permission denied"):
            list_folder(tmp_path, EXR)
    finally:
        tmp_path.chmod(0o700)


@given(st.lists(st.text(), max_size=8))
def test_natural_order_compares_any_names(texts):
    """Any names can be compared, and their order in the folder makes no difference."""
    ordered = [natural_key(text) for text in sorted(texts, key=natural_key)]
    assert ordered == [natural_key(text) for text in sorted(reversed(texts), key=natural_key)]


def test_natural_order_compares_numbers_by_value():
    assert natural_key("Shot9") < natural_key("shot10") < natural_key("shot10b")


def test_list_folder_keeps_two_sizes_of_an_image_separate(tmp_path):
    make_files(tmp_path, "hero720.exr", "hero1080.exr", "take1.exr", "take2.exr", "old.0001.exr")
    make_files(tmp_path, "old.0999.exr")
    assert entry_names(list_folder(tmp_path, EXR)) == [
        "hero720.exr",
        "hero1080.exr",
        "old.####.exr",
        "take#.exr",
    ]


def test_list_folder_single_lists_each_file_of_a_sequence(tmp_path):
    make_files(tmp_path, "shot.1001.exr", "shot.1002.exr", "take7.exr", "take8.exr", "still.exr")
    listing = list_folder(tmp_path, EXR, is_single=True)
    assert entry_names(listing) == sorted(entry.name for entry in tmp_path.iterdir())
    for entry in listing.entries:
        sequence = find_sequence(entry.path)
        assert sequence.is_single and sequence.path_at(sequence.first).name == entry.name


def test_find_sequence_opens_file_without_frame_number_alone(tmp_path):
    make_files(tmp_path, "hero720.exr", "hero1080.exr", "take1.exr", "take2.exr")
    assert find_sequence(tmp_path / "hero720.exr").is_single
    assert find_sequence(tmp_path / "take1.exr").present == (1, 2)
    assert find_sequence(tmp_path / "hero#.exr").present == (720, 1080)  # named as a sequence
