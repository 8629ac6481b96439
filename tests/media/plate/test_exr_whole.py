"""Test that an EXR cut short is recognized by its structure, and a complete one never is."""

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.media.plate.exr.exr_whole import find_incomplete, is_whole_exr
from support.deep_files import write_deep
from support.exports import export_shot, refused_export_message, write_plates
from support.exr_files import part_header, tiled_header, write_file, write_parts

HEIGHT, WIDTH = 45, 70
COMPRESSIONS = ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB")


def random_channels() -> dict[str, np.ndarray]:
    random = np.random.default_rng(1)
    return {name: random.random((HEIGHT, WIDTH)).astype(np.float16) for name in "RGB"}


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[Path]:
    """Return a file of each kind: every compression, tiled, of several parts, deep."""
    folder = tmp_path_factory.mktemp("kinds")
    found = [
        write_file(
            folder / f"{name}.exr",
            random_channels(),
            compression=getattr(OpenEXR, f"{name}_COMPRESSION"),
        )
        for name in COMPRESSIONS
    ]
    deep = [[(0.5, 1.0, 2.0)] * (1 + at % 3) for at in range(48)]
    found.append(write_deep(folder / "deep.exr", deep, (6, 8)))
    found.append(write_file(folder / "tiled.exr", random_channels(), **tiled_header()))
    parts = [
        (part_header(name=name) | more, random_channels()) for name, more in (("a", {}), ("b", {}))
    ]
    found.append(write_parts(folder / "parts.exr", *parts))
    tiled = [
        (part_header(name="a"), random_channels()),
        (part_header(name="b") | tiled_header(), random_channels()),
    ]
    found.append(write_parts(folder / "mixed.exr", *tiled))
    return found


def test_is_whole_exr_accepts_complete_files_of_every_kind(files):
    assert [path.name for path in files if not is_whole_exr(path)] == []
    assert find_incomplete(iter(files)) == []


@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_is_whole_exr_detects_any_truncation(files, tmp_path_factory, data):
    path = data.draw(st.sampled_from(files))
    content = path.read_bytes()
    cut = tmp_path_factory.mktemp("cut") / "cut.exr"
    cut.write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
    assert not is_whole_exr(cut) and find_incomplete(iter([cut])) == [cut]


def test_is_whole_exr_detects_chunks_never_written(files, tmp_path):
    """A renderer that was stopped leaves zeros in the chunk table of a file of full length."""
    content = bytearray(files[0].read_bytes())
    table = len(content) - HEIGHT * (8 + 8 + 3 * 2 * WIDTH)
    content[table + 8 : table + 16] = bytes(8)
    path = tmp_path / "stopped.exr"
    path.write_bytes(content)
    assert not is_whole_exr(path)


@pytest.mark.parametrize("length", [0, 5000])
def test_export_names_truncated_plates_before_it_starts(capsys, tmp_path, length):
    source = write_plates(tmp_path / "plates")
    first_damaged, last_damaged = (
        Path(source.replace("####", f"{frame}")) for frame in (1003, 1005)
    )
    words = ("--focus-distance", 2, "--f-stop", 2, "--focal-length", 50, "--sensor-width", 36)
    for path in (first_damaged, last_damaged):
        path.write_bytes(path.read_bytes()[: min(length, path.stat().st_size // 2)])
    message = refused_export_message(capsys, source, tmp_path / "out" / "o.####.exr", *words)
    assert first_damaged.name in message and last_damaged.name in message and "--frames" in message
    assert not (tmp_path / "out").exists()
    export_shot(capsys, source, tmp_path / "o.####.exr", "--frames", "1001-1002", *words)
