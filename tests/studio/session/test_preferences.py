"""Preferences that are kept from one start to the next, and damaged or wrong files of them."""

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
from heatlens.core.model.curves.frames import Ending
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.view.guides import PEAKING_COLORS, Guides, Peaking, PeakingOn
from heatlens.media.files import file_lock
from heatlens.media.live.ring.channel_map import ChannelMap, Ring
from heatlens.studio.settings.preferences import (
    FILE_NAME,
    Preferences,
    PreferenceValues,
    Theme,
    merge_changes,
)
from support.command_line import ENVIRONMENT
from support.patience import PATIENCE_S

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
    PreferenceValues,
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
FULL = PreferenceValues(
    ("/a/b.exr",), {"open": "/a"}, {"/a": PlateOptions(near_m=1.0)}, "D", "V", "ft"
)


def write(preferences: Preferences) -> None:
    saving = preferences.save_function()
    if saving is not None:
        saving()


def save_preferences(folder: Path, remembered: PreferenceValues) -> Path:
    preferences = Preferences.load(folder)
    preferences.values = remembered
    write(preferences)
    return folder / FILE_NAME


# The file


@given(REMEMBERED)
def test_loaded_preferences_equal_the_saved_ones(tmp_path_factory, remembered):
    folder = tmp_path_factory.mktemp("config")
    save_preferences(folder, remembered)
    loaded = Preferences.load(folder)
    assert (loaded.values, loaded.problem) == (remembered, "")


def test_missing_preferences_file_loads_defaults_and_writes_nothing(tmp_path):
    loaded = Preferences.load(tmp_path / "not" / "there")
    assert (loaded.values, loaded.problem) == (PreferenceValues(), "")
    write(loaded)
    assert list(tmp_path.iterdir()) == []  # nothing changed, nothing written


def test_preferences_file_is_readable_by_its_user_only(tmp_path):
    preferences = Preferences.load(tmp_path)
    preferences.remember_opened("/somewhere/private.exr")
    write(preferences)
    assert preferences.path is not None
    assert preferences.path.stat().st_mode & 0o777 == 0o600


def test_unchanged_preferences_are_not_written_again(tmp_path):
    path = save_preferences(tmp_path, FULL)
    preferences = Preferences.load(tmp_path)
    path.unlink()
    write(preferences)
    assert not path.exists()
    preferences.change(unit="m")
    write(preferences)
    assert path.exists()


def test_preferences_in_memory_write_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    preferences = Preferences()
    preferences.remember_opened("a.exr")
    write(preferences)
    assert list(tmp_path.iterdir()) == []


DAMAGED = [b"", b"{", b"[]", b"null", b"\xff\xfe\x00", b'{"unit": "m"', b'{"unit": NaN}']


@pytest.mark.parametrize("content", DAMAGED)
def test_damaged_preferences_file_is_reported_and_set_aside(tmp_path, content):
    (tmp_path / FILE_NAME).write_bytes(content)
    loaded = Preferences.load(tmp_path)
    assert loaded.values == PreferenceValues()
    assert FILE_NAME in loaded.problem and "settings are reset" in loaded.problem
    aside = tmp_path / "preferences.damaged.json"
    assert aside.exists() is bool(content) is (aside.name in loaded.problem)
    assert not content or aside.read_bytes() == content


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_preferences_at_a_pipe_or_device_are_reported_and_not_read(tmp_path, make):
    make(tmp_path / FILE_NAME)
    assert "it is not a file" in Preferences.load(tmp_path).problem


# Two windows


def test_preferences_of_two_windows_keep_the_changes_of_both(tmp_path):
    save_preferences(
        tmp_path, replace(FULL, recent=tuple(f"/old/{k}" for k in range(10)), folders={"a": "/"})
    )
    first_window, second_window = Preferences.load(tmp_path), Preferences.load(tmp_path)
    first_window.remember_opened("/one.exr")
    first_window.change(unit="m", ui_scales={"left": 1.5})
    first_window.remember_options(Path("/one"), PlateOptions(near_m=2.0))
    write(first_window)
    second_window.remember_opened("/two.exr")
    second_window.change(layout="mine", ui_scales={"right": 2.0}, folders={})
    write(second_window)
    write(first_window)  # nothing has changed since
    loaded = Preferences.load(tmp_path).values
    assert loaded.recent[:3] == ("/two.exr", "/one.exr", "/old/0") and len(loaded.recent) == 10
    assert (loaded.unit, loaded.layout, loaded.view) == ("m", "mine", FULL.view)
    assert loaded.ui_scales == {"left": 1.5, "right": 2.0} and loaded.folders == {}
    assert set(loaded.plates) == {"/a", "/one"}


@given(REMEMBERED, REMEMBERED, REMEMBERED)
def test_merge_changes_takes_own_changes_and_otherwise_their_values(theirs, before, after):
    theirs, before, after = (replace(values, recent=()) for values in (theirs, before, after))
    assert (
        merge_changes(before, before, after) == after
        and merge_changes(theirs, after, after) == theirs
    )
    merged_values = merge_changes(theirs, before, after)
    for name in ("display", "layout", "guides", "theme", "ring_maps"):
        changed = getattr(after, name) != getattr(before, name)
        assert getattr(merged_values, name) == getattr(after if changed else theirs, name)
    for name in after.plates:
        expected = after if after.plates[name] != before.plates.get(name) else theirs
        assert merged_values.plates.get(name) == expected.plates.get(name)


NAMES = st.lists(st.sampled_from([f"/p/{i}.exr" for i in range(14)]), max_size=10, unique=True)


@given(NAMES, NAMES, st.lists(st.sampled_from(["/a", "/b", "/c"])))
def test_merge_changes_begins_recent_files_with_those_opened_here(theirs, before, opened):
    mine = Preferences(PreferenceValues(recent=tuple(before)))
    for name in opened:
        mine.remember_opened(name)
    merged_values = merge_changes(
        PreferenceValues(recent=tuple(theirs)), PreferenceValues(recent=tuple(before)), mine.values
    )
    latest = list(dict.fromkeys(reversed(opened)))
    other_files = [name for name in theirs if name not in latest]
    assert list(merged_values.recent) == (latest + other_files)[:10]


def test_preferences_written_by_two_processes_lose_nothing(tmp_path):
    """Two processes write to one preferences file, as two windows do."""
    code = (
        "import sys; from pathlib import Path\n"
        "from heatlens.studio.settings.preferences import Preferences\n"
        "preferences = Preferences.load(Path(sys.argv[1]))\n"
        "for k in range(20):\n"
        "    preferences.remember_folder(f'{sys.argv[2]} {k}', Path('/there'))\n"
        "    preferences.save_function()()\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    windows = [subprocess.Popen([*command, name], env=ENVIRONMENT) for name in ("one", "two")]
    assert [window.wait(PATIENCE_S) for window in windows] == [0, 0]
    assert len(Preferences.load(tmp_path).values.folders) == 40


def test_held_lock_delays_saving_only_for_a_limited_time(tmp_path, monkeypatch):
    monkeypatch.setattr(file_lock, "_LOCK_WAIT_S", 0.1)
    with file_lock.lock_file(tmp_path / "preferences.lock"):
        save_preferences(tmp_path, FULL)
    assert Preferences.load(tmp_path).values == FULL


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
def test_wrong_preference_entry_is_reset_and_the_others_are_kept(tmp_path, wrong):
    path = save_preferences(tmp_path, FULL)
    (name,) = wrong
    path.write_text(json.dumps(json.loads(path.read_text()) | wrong))
    loaded = Preferences.load(tmp_path)
    for field in PreferenceValues.__dataclass_fields__:
        expected = PreferenceValues() if field == name else FULL
        assert getattr(loaded.values, field) == getattr(expected, field)
    assert name in loaded.problem


def test_unknown_preference_entries_are_ignored(tmp_path):
    path = save_preferences(tmp_path, FULL)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"phase of the moon": "full"}))
    loaded = Preferences.load(tmp_path)
    assert (loaded.values, loaded.problem) == (FULL, "")


def test_failed_write_of_preferences_is_reported_once(tmp_path):
    (tmp_path / "file").write_text("")
    preferences = Preferences.load(tmp_path / "file" / "heatlens")
    preferences.remember_opened("a.exr")
    with pytest.raises(InputError, match="Preferences cannot be saved"):
        write(preferences)
    preferences.remember_opened("b.exr")
    write(preferences)


# What is remembered


@given(st.lists(st.sampled_from([f"/p/{i}.exr" for i in range(14)]), max_size=40))
def test_recent_files_are_the_last_ten_different_ones_opened(opened):
    preferences = Preferences()
    for text in opened:
        preferences.remember_opened(text)
    assert list(preferences.values.recent) == list(dict.fromkeys(reversed(opened)))[:10]


def test_options_for_applies_only_to_files_of_the_same_folder(tmp_path):
    preferences, options = Preferences(), PlateOptions(scene_unit_m=0.01)
    preferences.remember_options(tmp_path, options)
    for text in (tmp_path / "a.exr", tmp_path / "a.####.exr", tmp_path):
        assert preferences.options_for(str(text)) == options
    for text in (tmp_path / "sub" / "a.exr", tmp_path.parent / "a.exr"):
        assert preferences.options_for(str(text)) == PlateOptions()
    preferences.remember_options(tmp_path, PlateOptions())
    assert preferences.values == PreferenceValues()


@given(OPTIONS, st.sampled_from(["auto", "distance", "inverse", "normalized", "disparity", "coc"]))
def test_near_and_far_are_kept_only_for_conventions_that_use_them(options, convention):
    """Ends of other conventions, from files of earlier versions, are dropped and reported once."""
    options = replace(options, depth_convention=convention)
    preferences = Preferences(PreferenceValues(plates={"/a": options}))
    restored_options = preferences.options_for("/a/b.exr")
    takes_ends = convention in ("auto", "normalized", "disparity")
    ends = (options.near_m, options.far_m) if takes_ends else (None, None)
    assert restored_options == replace(options, near_m=ends[0], far_m=ends[1])
    assert bool(preferences.problem) is (restored_options != options)
    preferences.problem = ""
    assert preferences.options_for("/a/c.exr") == restored_options and not preferences.problem
    preferences.remember_options(Path("/a"), options)
    assert preferences.options_for("/a/c.exr") == restored_options and not preferences.problem
