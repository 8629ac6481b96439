"""What is remembered from one start to the next, and files that say something else."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.view.guides import PEAKING_COLORS, Guides, Peaking, PeakingOn
from heatlens.media.files import atomic_file
from heatlens.media.live.ring.channel_map import ChannelMap, Ring
from heatlens.studio.session.settings.preferences import (
    FILE_NAME,
    Preferences,
    Remembered,
    Theme,
    merged,
)
from heatlens.studio.session.time.playback import Ending
from support.command_line import ENVIRONMENT

OPTIONS = st.builds(
    PlateOptions,
    depth_channel=st.none() | st.text(max_size=8),
    color_layer=st.none() | st.text(max_size=8),
    depth_convention=st.sampled_from(["auto", "inverse", "normalized"]),
    depth_kind=st.sampled_from(["planar", "radial"]),
    scene_unit_m=st.floats(1e-4, 1e4),
    near_m=st.none() | st.floats(0, 10),
    far_m=st.none() | st.floats(10, 1e6),
)
REMEMBERED = st.builds(
    Remembered,
    recent=st.lists(st.text(), max_size=4).map(tuple),
    folders=st.dictionaries(st.text(), st.text(), max_size=3),
    plates=st.dictionaries(st.text(), OPTIONS, max_size=3),
    display=st.text(max_size=9),
    view=st.text(max_size=9),
    unit=st.sampled_from(["m", "ft"]),
    guides=st.builds(
        Guides,
        aspect=st.none() | st.floats(0.1, 10),
        opacity=st.floats(0, 1),
        safe_areas=st.booleans(),
        thirds=st.booleans(),
        centre=st.booleans(),
    ),
    peaking=st.builds(
        Peaking,
        st.sampled_from(PeakingOn),
        stops=st.floats(0.05, 3),
        blur=st.floats(0.1, 4),
        color=st.sampled_from(list(PEAKING_COLORS)),
    ),
    window_size=st.none() | st.tuples(st.integers(200, 9999), st.integers(200, 9999)),
    is_maximized=st.booleans(),
    hidden_panels=st.lists(st.text(), max_size=2).map(tuple),
    layout=st.text(),
    ending=st.sampled_from(Ending),
    every_frame=st.booleans(),
    feed_labels=st.booleans(),
    theme=st.sampled_from(Theme),
    ring_maps=st.lists(
        st.builds(ChannelMap, st.text(max_size=5), st.sampled_from(Ring), bend=st.floats(0.2, 5.0)),
        max_size=3,
    ).map(tuple),
)
FULL = Remembered(("/a/b.exr",), {"open": "/a"}, {"/a": PlateOptions(near_m=1.0)}, "D", "V", "ft")


def write(preferences: Preferences) -> None:
    saving = preferences.saving()
    if saving is not None:
        saving()


def saved(folder: Path, now: Remembered) -> Path:
    preferences = Preferences.load(folder)
    preferences.now = now
    write(preferences)
    return folder / FILE_NAME


# The file


@given(REMEMBERED)
def test_what_is_saved_is_what_is_loaded(tmp_path_factory, now):
    folder = tmp_path_factory.mktemp("config")
    saved(folder, now)
    loaded = Preferences.load(folder)
    assert (loaded.now, loaded.problem) == (now, "")


def test_without_a_file_all_is_as_in_the_beginning(tmp_path):
    loaded = Preferences.load(tmp_path / "not" / "there")
    assert (loaded.now, loaded.problem) == (Remembered(), "")
    write(loaded)
    assert list(tmp_path.iterdir()) == []  # nothing changed, nothing written


def test_only_the_user_may_read_what_was_opened(tmp_path):
    preferences = Preferences.load(tmp_path)
    preferences.opened("/somewhere/private.exr")
    write(preferences)
    assert preferences.path is not None
    assert preferences.path.stat().st_mode & 0o777 == 0o600


def test_nothing_is_written_that_was_written_already(tmp_path):
    path = saved(tmp_path, FULL)
    preferences = Preferences.load(tmp_path)
    path.unlink()
    write(preferences)
    assert not path.exists()
    preferences.change(unit="m")
    write(preferences)
    assert path.exists()


def test_in_memory_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    preferences = Preferences()
    preferences.opened("a.exr")
    write(preferences)
    assert list(tmp_path.iterdir()) == []


DAMAGED = [b"", b"{", b"[]", b"null", b"\xff\xfe\x00", b'{"unit": "m"', b'{"unit": NaN}']


@pytest.mark.parametrize("content", DAMAGED)
def test_a_damaged_file_is_told_and_set_aside(tmp_path, content):
    (tmp_path / FILE_NAME).write_bytes(content)
    loaded = Preferences.load(tmp_path)
    assert loaded.now == Remembered()
    assert FILE_NAME in loaded.problem and "settings are reset" in loaded.problem
    aside = tmp_path / "preferences.damaged.json"
    assert aside.exists() is bool(content) is (aside.name in loaded.problem)
    assert not content or aside.read_bytes() == content


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_a_pipe_or_device_is_told_and_not_read(tmp_path, make):
    make(tmp_path / FILE_NAME)
    assert "it is not a file" in Preferences.load(tmp_path).problem


# Two windows


def test_two_windows_keep_the_changes_of_both(tmp_path):
    saved(tmp_path, replace(FULL, recent=tuple(f"/old/{k}" for k in range(10)), folders={"a": "/"}))
    one, two = Preferences.load(tmp_path), Preferences.load(tmp_path)
    one.opened("/one.exr")
    one.change(unit="m", ui_scales={"left": 1.5})
    one.read_so(Path("/one"), PlateOptions(near_m=2.0))
    write(one)
    two.opened("/two.exr")
    two.change(layout="mine", ui_scales={"right": 2.0}, folders={})
    write(two)
    write(one)  # nothing has changed since
    now = Preferences.load(tmp_path).now
    assert now.recent[:3] == ("/two.exr", "/one.exr", "/old/0") and len(now.recent) == 10
    assert (now.unit, now.layout, now.view) == ("m", "mine", FULL.view)
    assert now.ui_scales == {"left": 1.5, "right": 2.0} and now.folders == {}
    assert set(now.plates) == {"/a", "/one"}


@given(REMEMBERED, REMEMBERED, REMEMBERED)
def test_what_is_merged_has_what_changed_and_else_what_was_there(theirs, before, now):
    theirs, before, now = (replace(of, recent=()) for of in (theirs, before, now))
    assert merged(before, before, now) == now and merged(theirs, now, now) == theirs
    found = merged(theirs, before, now)
    for name in ("display", "layout", "guides", "theme", "ring_maps"):
        changed = getattr(now, name) != getattr(before, name)
        assert getattr(found, name) == getattr(now if changed else theirs, name)
    for name in now.plates:
        of = now if now.plates[name] != before.plates.get(name) else theirs
        assert found.plates.get(name) == of.plates.get(name)


NAMES = st.lists(st.sampled_from([f"/p/{i}.exr" for i in range(14)]), max_size=10, unique=True)


@given(NAMES, NAMES, st.lists(st.sampled_from(["/a", "/b", "/c"])))
def test_files_that_were_opened_come_first_and_others_stay(theirs, before, opened):
    mine = Preferences(Remembered(recent=tuple(before)))
    for name in opened:
        mine.opened(name)
    found = merged(Remembered(recent=tuple(theirs)), Remembered(recent=tuple(before)), mine.now)
    latest = list(dict.fromkeys(reversed(opened)))
    rest = [name for name in theirs if name not in latest]
    assert list(found.recent) == (latest + rest)[:10]


def test_windows_that_write_at_the_same_time_lose_nothing(tmp_path):
    """Each is a process of its own, as windows are."""
    code = (
        "import sys; from pathlib import Path\n"
        "from heatlens.studio.session.settings.preferences import Preferences\n"
        "preferences = Preferences.load(Path(sys.argv[1]))\n"
        "for k in range(20):\n"
        "    preferences.looked_in(f'{sys.argv[2]} {k}', Path('/there'))\n"
        "    preferences.saving()()\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    windows = [subprocess.Popen([*command, name], env=ENVIRONMENT) for name in ("one", "two")]
    assert [window.wait(60) for window in windows] == [0, 0]
    assert len(Preferences.load(tmp_path).now.folders) == 40


def test_a_window_that_was_stopped_holds_up_no_other(tmp_path, monkeypatch):
    monkeypatch.setattr(atomic_file, "_PATIENCE_S", 0.1)
    with atomic_file.locked(tmp_path / "preferences.lock"):
        saved(tmp_path, FULL)
    assert Preferences.load(tmp_path).now == FULL


WRONG = [
    {"unit": "parsec"},
    {"recent": "a.exr"},
    {"recent": [3]},
    {"folders": ["a"]},
    {"plates": {"/a": {"near_m": "close"}}},
    {"plates": {"/a": {"nearest": 1}}},
    {"window_size": [800]},
    {"window_size": [-1, 800]},
    {"window_size": [1e9, 800]},
    {"window_size": "large"},
    {"is_maximized": 1},
    {"layout": None},
    {"ending": "explode"},
    {"theme": "pink"},
    {"feed_labels": "yes"},
    {"guides": {"aspect": 0}},
    {"guides": {"opacity": 1.5}},
    {"guides": {"thirds": 1}},
    {"guides": "thirds"},
    {"guides": {"desqueeze": "inf"}},
    {"peaking": {"color": "puce"}},
    {"peaking": {"stops": -1}},
    {"peaking": {"blur": 1e9}},
    {"peaking": {"on": "everything"}},
    {"every_frame": "no"},
]


@pytest.mark.parametrize("wrong", WRONG)
def test_one_wrong_entry_costs_no_other(tmp_path, wrong):
    path = saved(tmp_path, FULL)
    (name,) = wrong
    path.write_text(json.dumps(json.loads(path.read_text()) | wrong))
    loaded = Preferences.load(tmp_path)
    for field in Remembered.__dataclass_fields__:
        of = Remembered() if field == name else FULL
        assert getattr(loaded.now, field) == getattr(of, field)
    assert name in loaded.problem


def test_entries_of_another_version_are_passed_over(tmp_path):
    path = saved(tmp_path, FULL)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"phase of the moon": "full"}))
    loaded = Preferences.load(tmp_path)
    assert (loaded.now, loaded.problem) == (FULL, "")


def test_where_nothing_can_be_written_it_is_said_once(tmp_path):
    (tmp_path / "file").write_text("")
    preferences = Preferences.load(tmp_path / "file" / "heatlens")
    preferences.opened("a.exr")
    with pytest.raises(InputError, match="Preferences cannot be saved"):
        write(preferences)
    preferences.opened("b.exr")
    write(preferences)


# What is remembered


@given(st.lists(st.sampled_from([f"/p/{i}.exr" for i in range(14)]), max_size=40))
def test_recent_files_are_the_last_ten_different_ones(opened):
    preferences = Preferences()
    for text in opened:
        preferences.opened(text)
    assert list(preferences.now.recent) == list(dict.fromkeys(reversed(opened)))[:10]


def test_options_count_for_the_files_of_their_folder_alone(tmp_path):
    preferences, options = Preferences(), PlateOptions(scene_unit_m=0.01)
    preferences.read_so(tmp_path, options)
    for text in (tmp_path / "a.exr", tmp_path / "a.####.exr", tmp_path):
        assert preferences.options_for(str(text)) == options
    for text in (tmp_path / "sub" / "a.exr", tmp_path.parent / "a.exr"):
        assert preferences.options_for(str(text)) == PlateOptions()
    preferences.read_so(tmp_path, PlateOptions())
    assert preferences.now == Remembered()


@given(OPTIONS, st.sampled_from(["auto", "distance", "inverse", "normalized", "disparity", "coc"]))
def test_ends_are_remembered_where_the_depth_has_ends(options, convention):
    """Files of earlier versions may hold others; these are dropped once, and told."""
    options = replace(options, depth_convention=convention)
    preferences = Preferences(Remembered(plates={"/a": options}))
    found = preferences.options_for("/a/b.exr")
    takes_ends = convention in ("auto", "normalized", "disparity")
    ends = (options.near_m, options.far_m) if takes_ends else (None, None)
    assert found == replace(options, near_m=ends[0], far_m=ends[1])
    assert bool(preferences.problem) is (found != options)
    preferences.problem = ""
    assert preferences.options_for("/a/c.exr") == found and not preferences.problem
    preferences.read_so(Path("/a"), options)
    assert preferences.options_for("/a/c.exr") == found and not preferences.problem
