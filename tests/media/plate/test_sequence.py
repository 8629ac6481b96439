"""Test sequences on disk: notations, gaps, substitutes, and files that come and go."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.sequence import sequence as sequence_module
from heatlens.media.sequence.names import (
    NameForm,
    are_frames,
    frames_text,
    parse_frame_name,
    parse_frames,
)
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence, rescan
from support.watched_calls import watch_calls

SHOT = (998, 999, 1001, 1002, 1005)  # 1000, 1003 and 1004 are missing

# Prefixes that a frame number can be told from: not ending in a digit, and no version.
PREFIXES = st.text("ab1._- @#%$F(", max_size=6).filter(
    lambda text: not text[-1:].isdigit() and not text.endswith("-") and not text.startswith(".")
)
SUFFIXES = st.sampled_from([".exr", ".left.exr", ".v02.exr", ".EXR"])
FRAMES = st.sets(st.integers(-1200, 1200) | st.integers(9990, 10010), min_size=1, max_size=8)


def touch(folder: Path, *names: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()
    return folder


@pytest.fixture
def shot(tmp_path):
    return touch(tmp_path / "shot", *(f"shot.{frame:04d}.exr" for frame in SHOT))


@pytest.mark.parametrize(
    "name",
    [
        *("shot.####.exr", "shot.#.exr", "shot.%04d.exr", "shot.%d.exr", "shot.@@@@.exr"),
        *("shot.$F4.exr", "shot.$F.exr", "shot.1001.exr", "", "shot.998-1005####.exr"),
    ],
)
def test_find_sequence_accepts_every_notation(shot, name):
    sequence = find_sequence(shot / name)
    assert sequence.frames == tuple(range(998, 1006))
    assert sequence.present == SHOT and sequence.missing == (1000, 1003, 1004)
    assert (sequence.first, sequence.last, sequence.is_single) == (998, 1005, False)
    assert sequence.path_at(998) == shot / "shot.0998.exr"
    assert sequence.pattern == str(shot / "shot.####.exr")


@pytest.mark.parametrize(
    ("name", "frames"),
    [
        ("shot.998-1005x3####.exr", None),
        ("shot.998-1005x3%04d.exr", None),
        ("shot.####.exr", "998-1005x3"),
        ("shot.1-2####.exr", "998-1005x3"),
        ("shot.1002.exr", "998,1001,1004"),
        ("", "1004-998x-3"),
    ],
)
def test_find_sequence_limits_frames_to_range(shot, name, frames):
    sequence = find_sequence(shot / name, frames)
    assert sequence.frames == (998, 1001, 1004)
    assert sequence.present == (998, 1001) and sequence.missing == (1004,)


def test_find_sequence_of_file_is_whole_sequence_or_that_file(shot):
    single = find_sequence(shot / "shot.1002.exr", whole=False)
    assert single.frames == single.present == (1002,) and single.is_single
    assert find_sequence(shot / "shot.1002.exr").frame_at(shot / "shot.1002.exr") == 1002
    assert single.frame_at(shot / "shot.1001.exr") is None
    assert find_sequence(single.pattern, single.frame_range) == single


@pytest.mark.parametrize("name", ["plate.exr", "plate_v02.exr", "plate_4k.exr", "a#b@c.exr"])
def test_find_sequence_of_name_without_number_is_single(tmp_path, name):
    touch(tmp_path, name, "plate_v01.exr")
    still = find_sequence(tmp_path / name)
    assert still.is_single and not still.missing
    assert still.path_at(still.first) == tmp_path / name
    assert still.frame_at(tmp_path / name) == still.first
    assert find_sequence(still.pattern) == rescan(still) == still
    assert still.frame_at(tmp_path / "other.exr") is None


@given(data=st.data(), prefix=PREFIXES, suffix=SUFFIXES, padding=st.integers(1, 6), frames=FRAMES)
def test_find_sequence_finds_files_of_any_padded_name(
    tmp_path_factory, data, prefix, suffix, padding, frames
):
    if prefix[-1:].isalnum():  # there a minus is a hyphen
        frames = {abs(frame) for frame in frames}
    names = {frame: f"{prefix}{frame:0{padding}d}{suffix}" for frame in frames}
    if parse_frame_name(names[min(frames)])[1] is None:
        return  # a version
    folder = touch(tmp_path_factory.mktemp("any"), *names.values(), f"{prefix}x{suffix}", "z.txt")
    form = NameForm(prefix, padding, suffix)
    # By one of its files, and by the pattern where the name around it holds no marks of its own.
    of_files = [names[data.draw(st.sampled_from(sorted(frames)))]]
    if len(frames) > 1 and not are_frames(form, sorted(frames)):
        of_files = []  # sizes or versions, of which each is opened by itself
    texts = of_files + [form.text] * form.is_notation
    for sequence in (find_sequence(folder / text) for text in texts):
        assert sequence.frames == tuple(range(min(frames), max(frames) + 1))
        assert {f: sequence.path_at(f).name for f in sequence.present} == names
        assert all(sequence.frame_at(folder / name) == f for f, name in names.items())
        assert find_sequence(sequence.pattern, sequence.frame_range) == rescan(sequence) == sequence


@pytest.mark.parametrize(
    ("name", "prefix", "number"),
    [
        ("shot.1001.exr", "shot.", 1001),
        ("shot1001.exr", "shot", 1001),
        ("1001.exr", "", 1001),
        ("-5.exr", "", -5),
        ("shot.-0005.exr", "shot.", -5),
        ("shot-1001.exr", "shot-", 1001),
        ("sh010.comp0001.exr", "sh010.comp", 1),
        ("sh010_v02.beauty.1001.exr", "sh010_v02.beauty.", 1001),
        ("shot.1001.left.exr", "shot.", 1001),
        ("shot.1001.v02.exr", "shot.", 1001),
        ("mov01.exr", "mov", 1),
        ("shot_v02.exr", "shot_v02.exr", None),
        ("shot.exr", "shot.exr", None),
        ("1001", "1001", None),
    ],
)
def test_parse_frame_name_finds_frame_number(name, prefix, number):
    form, frame_number = parse_frame_name(name)
    assert (form.prefix, frame_number) == (prefix, number)


def test_find_sequence_separates_paddings_and_allows_longer_numbers(tmp_path):
    touch(tmp_path, "a.9999.exr", "a.10000.exr", "a.01.exr", "a.7.exr")
    assert find_sequence(tmp_path / "a.####.exr").present == (9999, 10000)
    assert find_sequence(tmp_path / "a.##.exr").present == (1, 9999, 10000)
    assert find_sequence(tmp_path / "a.7.exr").present == (7, 9999, 10000)
    touch(tmp_path, "a.001.exr")
    with pytest.raises(InputError, match=r"a\.###\.exr .*a\.##\.exr .*one # for each digit"):
        find_sequence(tmp_path / "a.#.exr")


def test_find_sequence_separates_digits_in_name_from_range(tmp_path):
    touch(tmp_path, "take20001.exr", "take20002.exr", "shot-1001.exr", "shot-1002.exr")
    assert find_sequence(tmp_path / "take2####.exr").present == (1, 2)
    assert find_sequence(tmp_path / "shot-1001-1002####.exr").present == (1001, 1002)


def test_find_sequence_ignores_marks_in_folder_names(tmp_path):
    folder = touch(tmp_path / "@a#1-5%04d[x]", "a.1.exr", "a.2.exr")
    assert find_sequence(folder / "a.#.exr").present == (1, 2)
    assert find_sequence(folder).present == (1, 2)


def test_find_sequence_of_folder_ignores_stills_and_other_files(tmp_path):
    touch(tmp_path, "a.1.exr", "a.2.exr", "._a.3.exr", "chart.exr", "a.1.png", "note.txt")
    assert find_sequence(tmp_path).present == (1, 2)


def test_find_sequence_of_ambiguous_folder_lists_its_content(tmp_path):
    with pytest.raises(InputError, match=r"holds no EXR file"):
        find_sequence(tmp_path)
    touch(tmp_path, "a.1.exr", "a.2.exr", "b.01.exr", "b.02.exr")
    with pytest.raises(InputError, match=r"a\.#\.exr \(1-2\), b\.##\.exr \(1-2\)"):
        find_sequence(tmp_path)


@pytest.mark.parametrize(
    ("name", "frames", "message"),
    [
        ("shoot.####.exr", None, r"shoot\.####\.exr.*shot\.####\.exr \(998-999,1001-1002,1005\)"),
        ("shot.#####.exr", None, r"shot\.#####\.exr.*shot\.####\.exr"),
        ("shot.exr", None, r"is not there.*shot\.####\.exr \(998"),
        ("shot.<UDIM>.exr", None, "neither a file nor a pattern"),
        ("shot.####.####.exr", None, "neither a file nor a pattern"),
        ("a\0b.exr", None, "is not there"),
        ("x" * 300, None, "is not there"),
        ("gone/shot.####.exr", None, "gone does not exist"),
        ("shot.1100-1200####.exr", None, r"no file for frames 1100-1200: there are 998-999"),
        ("shot.####.exr", "1000", r"no file for frames 1000: there are 998-999"),
        ("shot.####.exr", "first", "Frames 'first' cannot be read: write 1001-1100"),
        ("shot.####.exr", "", "Frames '' cannot be read"),
        ("shot.####.exr", "1-2x0.5", "Frames '1-2x0.5' cannot be read"),
        ("shot.####.exr", "1001 1002", "Frames '1001 1002' cannot be read"),
        ("shot.####.exr", "1-2000000", "up to 1,000,000"),
        ("shot.####.exr", "1-99999999999", "cannot be read|up to"),
    ],
)
def test_find_sequence_error_lists_existing_sequences(shot, name, frames, message):
    with pytest.raises(InputError, match=message):
        find_sequence(shot / name, frames)


def test_find_sequence_rejects_date_as_frame_number(tmp_path):
    touch(tmp_path, "a_1001.exr", "a_20240131.exr")
    with pytest.raises(InputError, match=r"go from 1001 to 20240131.*name those"):
        find_sequence(tmp_path / "a_1001.exr")
    assert find_sequence(tmp_path / "a_20240131.exr", whole=False).frames == (20240131,)


def test_find_sequence_lists_folder_only_once(tmp_path, monkeypatch):
    touch(tmp_path, *(f"a.{frame:04d}.exr" for frame in range(3000)))
    listings = watch_calls(monkeypatch, sequence_module.os, "scandir")
    for name in ("a.####.exr", "a.#.exr", "a.0007.exr", ""):
        assert len(find_sequence(tmp_path / name).present) == 3000
    assert len(listings) == 4


@given(frames=st.sets(st.integers(-50, 50), min_size=1))
def test_parse_frames_reads_back_frames_text(frames):
    assert parse_frames(frames_text(frames)) == tuple(sorted(frames))


@given(
    wanted=st.sets(st.integers(-20, 20), min_size=1),
    on_disk=st.sets(st.integers(-20, 20)),
    frame=st.integers(-25, 25),
)
def test_missing_frame_is_held_black_or_an_error(wanted, on_disk, frame):
    present = tuple(sorted(wanted & on_disk))
    form = NameForm(prefix="a.", padding=4, suffix=".exr")
    sequence = Sequence(Path("folder"), form, tuple(sorted(wanted)), present)
    earlier = [candidate for candidate in present if candidate <= frame]
    held_frame = max(earlier) if earlier else min(present, default=None)
    assert sequence.shown_frame(frame, "hold") == held_frame
    assert sequence.resolve(frame, "hold") == (
        None if held_frame is None else sequence.path_at(held_frame)
    )
    assert sequence.shown_frame(frame, "black") == (frame if frame in present else None)
    assert sequence.has_file(frame) == (frame in present)
    assert set(sequence.missing) == wanted - on_disk
    if frame in present:
        assert sequence.resolve(frame, "stop") == sequence.path_at(frame)
    else:
        with pytest.raises(InputError, match="is missing"):
            sequence.resolve(frame, "stop")


def test_rescanned_sequence_grows_and_does_not_shrink(shot):
    sequence = find_sequence(shot / "shot.####.exr")
    limited_sequence = find_sequence(shot / "shot.####.exr", "998-1004")
    touch(shot, "shot.1003.exr", "shot.1007.exr")
    grown_sequence = rescan(sequence)
    assert (grown_sequence.last, grown_sequence.missing) == (1007, (1000, 1004, 1006))
    assert rescan(limited_sequence).frames == limited_sequence.frames
    assert rescan(limited_sequence).present == (998, 999, 1001, 1002, 1003)
    (shot / "shot.0998.exr").unlink()
    (shot / "shot.1007.exr").unlink()
    assert (
        rescan(grown_sequence).frames == grown_sequence.frames
        and rescan(grown_sequence).present[0] == 999
    )
    for path in shot.iterdir():
        path.unlink()
    empty_sequence = rescan(grown_sequence)
    assert empty_sequence.frames == grown_sequence.frames and empty_sequence.present == ()
    assert empty_sequence.resolve(1001) is None
    shot.rmdir()
    with pytest.raises(InputError, match="cannot be listed"):
        rescan(grown_sequence)


@pytest.mark.parametrize("name", ["p.{}.exr", "p.{}#.exr", "p.1-{}####.exr", "p.1-9x{}####.exr"])
def test_find_sequence_rejects_number_of_hundreds_of_digits(tmp_path, name):
    with pytest.raises(InputError):
        find_sequence(tmp_path / name.format("9" * 400)).require()
