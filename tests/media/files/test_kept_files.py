"""A folder of kept files stays below its limit; those not used for longest are deleted."""

import os
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.files.kept_files import keep_file, read_kept_file

MOST = 100


@given(st.lists(st.tuples(st.sampled_from("abcdefgh"), st.integers(1, MOST)), max_size=30))
def test_folder_is_that_of_a_least_recently_used_cache(tmp_path_factory, steps):
    """Each step reads the file of a name, or keeps one of some bytes where there is none."""
    folder, expected, now = tmp_path_factory.mktemp("kept"), dict[str, bytes](), 0
    for name, size in steps:
        now += 1
        content, path = expected.pop(name, None), folder / name
        assert read_kept_file(path) == content
        if content is None:
            content = bytes(size)
            while sum(map(len, expected.values())) + size > MOST:
                del expected[next(iter(expected))]
            keep_file(path, content, MOST)
        expected[name] = content
        os.utime(path, (now, now))
        assert {file.name for file in folder.iterdir()} == expected.keys()


def test_file_is_not_kept_where_its_folder_cannot_be_made(tmp_path: Path):
    (tmp_path / "folder").write_bytes(b"a file")
    keep_file(tmp_path / "folder" / "name", b"content", MOST)
    assert read_kept_file(tmp_path / "folder" / "name") is None
