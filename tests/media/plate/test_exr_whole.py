"""A file that was cut short is told by its structure; a whole one of any kind never is."""

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.media.plate.exr.exr_whole import cut_short, is_whole_exr
from support.deep_files import write_deep
from support.exports import exported, refused, write_plates
from support.exr_files import part_header, tiled_header, write_file, write_parts

HEIGHT, WIDTH = 45, 70
COMPRESSIONS = ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB")


def noise() -> dict[str, np.ndarray]:
    random = np.random.default_rng(1)
    return {name: random.random((HEIGHT, WIDTH)).astype(np.float16) for name in "RGB"}


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[Path]:
    """Return a file of each kind: every compression, tiled, of several parts, deep."""
    folder = tmp_path_factory.mktemp("kinds")
    found = [
        write_file(
            folder / f"{name}.exr", noise(), compression=getattr(OpenEXR, f"{name}_COMPRESSION")
        )
        for name in COMPRESSIONS
    ]
    deep = [[(0.5, 1.0, 2.0)] * (1 + at % 3) for at in range(48)]
    found.append(write_deep(folder / "deep.exr", deep, (6, 8)))
    found.append(write_file(folder / "tiled.exr", noise(), **tiled_header()))
    parts = [(part_header(name=name) | more, noise()) for name, more in (("a", {}), ("b", {}))]
    found.append(write_parts(folder / "parts.exr", *parts))
    tiled = [(part_header(name="a"), noise()), (part_header(name="b") | tiled_header(), noise())]
    found.append(write_parts(folder / "mixed.exr", *tiled))
    return found


def test_whole_files_are_whole(files):
    assert [path.name for path in files if not is_whole_exr(path)] == []
    assert cut_short(iter(files)) == []


@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_whatever_is_cut_off_is_missed(files, tmp_path_factory, data):
    path = data.draw(st.sampled_from(files))
    content = path.read_bytes()
    cut = tmp_path_factory.mktemp("cut") / "cut.exr"
    cut.write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
    assert not is_whole_exr(cut) and cut_short(iter([cut])) == [cut]


def test_chunks_that_were_never_written_are_missed(files, tmp_path):
    """A renderer that was stopped leaves zeros in the table of a file of its full length."""
    content = bytearray(files[0].read_bytes())
    table = len(content) - HEIGHT * (8 + 8 + 3 * 2 * WIDTH)
    content[table + 8 : table + 16] = bytes(8)
    path = tmp_path / "stopped.exr"
    path.write_bytes(content)
    assert not is_whole_exr(path)


@pytest.mark.parametrize("length", [0, 5000])
def test_an_export_names_cut_plates_before_it_starts(capsys, tmp_path, length):
    source = write_plates(tmp_path / "plates")
    first, last = (Path(source.replace("####", f"{frame}")) for frame in (1003, 1005))
    words = ("--focus-distance", 2, "--f-stop", 2, "--focal-length", 50, "--sensor-width", 36)
    for path in (first, last):
        path.write_bytes(path.read_bytes()[: min(length, path.stat().st_size // 2)])
    said = refused(capsys, source, tmp_path / "out" / "o.####.exr", *words)
    assert first.name in said and last.name in said and "--frames" in said
    assert not (tmp_path / "out").exists()
    exported(capsys, source, tmp_path / "o.####.exr", "--frames", "1001-1002", *words)
