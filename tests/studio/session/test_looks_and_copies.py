"""Looks beside each other, and pictures that are saved and copied."""

import stat
import threading
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Against, Compare, ViewState
from heatlens.media.files.still_text import pixels_of_still, still_of
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.render.gpu.textures import download
from heatlens.studio.board.session import Session
from heatlens.studio.session.pictures import picture_commands
from heatlens.studio.session.pictures.look_commands import LookCommands
from heatlens.studio.session.pictures.picture_commands import clipboard_tools, copy_png
from heatlens.studio.session.shot.editing import Editing
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.evening import begin_session, run_loop_once, run_until, run_until_settled
from support.patience import PATIENCE_S
from support.session_files import QUICK, room_file
from support.shared import shared_of

LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture
def messages():
    return []


@pytest.fixture
def looks(messages):
    shot = Shot(LENS, looks=tuple(Look(name, LENS) for name in "ABCDE"))
    return LookCommands(shared_of(Editing(shot, messages.append), messages.append), PictureView())


def view_state(looks):
    return looks._view.state


def test_back_alternates_between_the_last_two_lenses(looks, messages):
    looks.use_previous_lens()
    assert "lens" in messages[-1]
    other = replace(LENS, f_stop=8.0)
    looks._editing.edit_lens(other)
    looks.use_number(0)
    assert looks._editing.lens == LENS and not looks._editing.is_unsettled
    for lens in (other, LENS, other):
        looks.use_previous_lens()
        assert looks._editing.lens == lens
    looks.use_named("C")
    assert looks._editing.lens == LENS
    looks.use_named("none")
    looks.use_named("C")  # the same again is no way back to itself
    looks.use_previous_lens()
    assert looks._editing.lens == other


def test_only_the_first_nine_looks_get_a_shortcut(looks, messages):
    for number in range(6, 11):
        looks.keep()
        assert (f"Ctrl+{number}" in messages[-1]) is (number <= 9)
    looks.keep("abc")
    assert looks.looks[-1].still == "abc"


def test_compare_and_compare_as_a_keep_the_two_looks_different(looks, messages):
    a, b, c, *_ = looks.looks
    looks.compare(b)
    looks.compare_as_a(a)
    assert (view_state(looks).a_look, view_state(looks).b_look) == ("A", "B")
    looks.compare_as_a(b)
    assert (view_state(looks).a_look, view_state(looks).b_look) == ("B", "A")
    looks.compare_as_a(b)
    assert view_state(looks).a_look == "" and view_state(looks).compare is Compare.WIPE
    looks.compare_as_a(c)
    looks.compare(c)
    assert (view_state(looks).a_look, view_state(looks).b_look) == ("", "C")
    looks._view.state = replace(view_state(looks), compare=Compare.DIFFERENCE, a_look="A")
    looks.compare(b)
    assert view_state(looks).compare is Compare.DIFFERENCE and view_state(looks).a_look == "A"
    looks._view.state = ViewState(a_look="A")  # left from before
    looks.compare(b)
    assert view_state(looks).a_look == "" and view_state(looks).against is Against.LOOK
    looks._editing.do(replace(looks._editing.shot, looks=(a,)))
    looks.compare_as_a(a)
    assert "look" in messages[-1] and view_state(looks).a_look == ""


def test_grid_holds_four_looks_and_a_fifth_replaces_the_first(looks, messages):
    looks.toggle_grid()
    assert view_state(looks).compare is Compare.GRID
    looks.toggle_in_grid(looks.looks[4])
    assert view_state(looks).grid == ("B", "C", "D", "E")
    looks.toggle_in_grid(looks.looks[2])
    assert view_state(looks).grid == ("B", "D", "E")
    looks.toggle_in_grid(looks.looks[0])
    assert view_state(looks).grid == ("B", "D", "E", "A")
    looks.toggle_grid()
    assert view_state(looks).compare is Compare.OFF
    looks._editing.do(Shot(LENS))
    looks.toggle_grid()
    assert view_state(looks).compare is Compare.OFF and "look" in messages[-1]


def test_still_of_look_is_a_small_jpeg_and_wrong_data_is_refused():
    pixels = np.zeros((20, 30, 3), np.uint8)
    pixels[:, 15:] = (200, 100, 50)
    back = pixels_of_still(still_of(pixels))
    assert back.shape == (20, 30, 3) and abs(back.astype(int) - pixels).mean() < 6
    assert pixels_of_still(still_of(np.zeros((1, 1024, 3), np.uint8))) is not None
    for wrong in (still_of(np.zeros((1, 1025, 3), np.uint8)), "no base64!", "aGVsbG8="):
        assert pixels_of_still(wrong) is None


@pytest.fixture
def grid(ctx, renderer, tmp_path):
    """Return a session that shows two looks of a plate in a grid."""
    plate = room_file(tmp_path / "room.exr", 48, 32)
    session = Session(
        renderer,
        Start(str(plate), defocus=QUICK),
        preferences=Preferences.load(tmp_path / "preferences"),
    )
    session.begin()
    run_until_settled(session)
    shot = session.editing.shot
    looks = (Look(name, replace(shot.lens, f_stop=f_stop)) for name, f_stop in (("A", 2), ("B", 8)))
    session.editing.do(replace(shot, looks=tuple(looks)))
    session.pictures.looks.toggle_grid()
    yield session
    session.close()


def test_grid_renders_the_frame_through_each_look(grid, renderer):
    pictures = grid.pictures.sides.looks
    run_until_settled(grid)
    run_until(grid, lambda: None not in map(pictures.picture_of, "AB"), "both looks")
    run_until(grid, lambda: not any(map(pictures.is_unfinished, "AB")), "whole pictures")
    shot = grid.editing.shot
    for look in shot.looks:
        shown = pictures.picture_of(look.name)
        expected = renderer.pixels(shot.with_look(look))
        np.testing.assert_allclose(download(shown.texture), expected, atol=2e-3, rtol=2e-3)
    assert len(pictures.output) == 2 and pictures.picture_of("C") is None
    assert not pictures.is_working and not pictures.has_work()
    first = pictures.picture_of("A")
    grid.editing.do(replace(shot, looks=shot.looks[1:]))
    run_loop_once(grid)
    assert (
        pictures.picture_of("A") is None
        and pictures.picture_of("B") is not None
        and first is not None
    )
    grid.pictures.looks.toggle_grid()
    run_loop_once(grid)
    assert pictures.output == ()


# Saving and copying


def test_saved_picture_equals_the_render_and_never_overwrites_source(grid, renderer, tmp_path):
    grid.pictures.looks.toggle_grid()
    saving = grid.pictures.saving
    saving.save(tmp_path / "out.exr")
    assert saving.is_busy and "saving out.exr" in grid.messages.text
    run_until(grid, lambda: not saving.is_busy, "the file")
    assert grid.messages.text == f"Saved {tmp_path / 'out.exr'}."
    ((_, channels),) = read_parts(tmp_path / "out.exr")
    saved = np.stack([channels[name] for name in "RGB"], axis=-1)
    np.testing.assert_allclose(saved, renderer.pixels(grid.editing.shot)[..., :3], rtol=2e-3)
    source = grid.editing.shot.source
    saving.save(type(tmp_path)(source))
    run_until(grid, lambda: not saving.is_busy, "the refusal")
    assert "room.exr" in grid.messages.text and "Saved" not in grid.messages.text
    saving.save(tmp_path / "left.exr")
    grid.editing.frame += 1
    run_loop_once(grid)
    assert "left.exr" in grid.messages.text and not (tmp_path / "left.exr").exists()


def test_copy_reports_when_nothing_is_open(tmp_path):
    session = begin_session(tmp_path / "preferences")
    session.pictures.saving.copy()
    assert session.messages.text and not session.pictures.saving.is_busy
    session.close()


def write_tool(folder, name, script):
    """Write an executable shell script, and return its path."""
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def test_clipboard_tools_for_each_system(tmp_path):
    path = tmp_path / 'a "b" c.png'
    (mac,) = clipboard_tools(path, "darwin", {})
    assert mac.argv[:2] == ("osascript", "-e") and '\\"b\\"' in mac.argv[2] and not mac.reads_stdin
    (windows,) = clipboard_tools(tmp_path / "it's.png", "win32", {})
    assert windows.argv[0] == "powershell" and "it''s.png" in windows.argv[-1]
    assert [t.argv[0] for t in clipboard_tools(path, "linux", {"DISPLAY": ":0"})] == ["xclip"]
    tools = clipboard_tools(path, "linux", {"DISPLAY": ":0", "WAYLAND_DISPLAY": "w"})
    assert [t.argv[0] for t in tools] == ["wl-copy", "xclip"] and all(t.reads_stdin for t in tools)
    assert clipboard_tools(path, "linux", {"DISPLAY": ""}) == ()


@pytest.mark.parametrize(
    ("platform", "environ", "word"),
    [
        ("darwin", {}, "osascript"),
        ("win32", {}, "powershell"),
        ("linux", {"WAYLAND_DISPLAY": "w", "DISPLAY": ":0"}, "wl-clipboard"),
        ("linux", {"DISPLAY": ":0"}, "xclip"),
        ("linux", {}, "no desktop"),
    ],
)
def test_copy_png_names_the_missing_clipboard_tool(tmp_path, platform, environ, word):
    with pytest.raises(InputError, match=word):
        copy_png(tmp_path / "a.png", platform, environ, lambda name: None)


def test_copy_png_uses_the_first_clipboard_tool_that_works(tmp_path, monkeypatch):
    picture = tmp_path / "a.png"
    Image.new("RGB", (2, 2)).save(picture)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    environ = {"DISPLAY": ":0", "WAYLAND_DISPLAY": "w"}
    write_tool(tmp_path, "wl-copy", "echo no compositor; exit 3")
    write_tool(tmp_path, "xclip", f"cat > {tmp_path}/copied")
    copy_png(picture, "linux", environ, lambda name: name)
    assert (tmp_path / "copied").read_bytes() == picture.read_bytes()
    write_tool(tmp_path, "xclip", "exit 4")
    with pytest.raises(InputError, match="wl-copy: no compositor"):
        copy_png(picture, "linux", environ, lambda name: name)
    with pytest.raises(InputError, match="xclip: exit code 4"):
        copy_png(picture, "linux", {"DISPLAY": ":0"}, lambda name: name)


def test_copy_png_does_not_wait_for_a_tool_that_stays_to_serve(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    write_tool(tmp_path, "xclip", "cat > /dev/null; (sleep 60) &")
    (tmp_path / "p.png").write_bytes(b"png")
    copy_png(tmp_path / "p.png", "linux", {"DISPLAY": ":0"}, lambda name: name)


# Writing on a thread


@pytest.fixture
def room_session(ctx, renderer, tmp_path):
    """Yield a session whose picture of a room is whole."""
    path = room_file(tmp_path / "room.exr", 8, 6)
    session = Session(renderer, Start(str(path), defocus=QUICK))
    session.begin()
    run_until_settled(session)
    yield session
    session.close()


def test_picture_is_written_on_a_thread_and_close_waits_for_it(room_session, tmp_path, monkeypatch):
    may_write, real_write_picture = threading.Event(), picture_commands.write_picture

    def write_slowly(*words, **keywords):
        assert may_write.wait(PATIENCE_S)
        real_write_picture(*words, **keywords)

    monkeypatch.setattr(picture_commands, "write_picture", write_slowly)
    saving = room_session.pictures.saving
    saving.save(tmp_path / "a.exr")
    for _ in range(5):
        run_loop_once(room_session)  # it goes on although nothing is written
    assert saving.is_busy and not (tmp_path / "a.exr").exists()
    saving.copy()
    assert "still being written" in room_session.messages.text
    threading.Timer(0.2, may_write.set).start()
    saving.close()
    assert (tmp_path / "a.exr").exists()


def test_failed_save_is_reported(room_session, tmp_path, monkeypatch):
    def fail(*_words, **_named):
        raise InputError("no room")

    monkeypatch.setattr(picture_commands, "write_picture", fail)
    room_session.pictures.saving.save(tmp_path / "a.exr")
    run_until(room_session, lambda: not room_session.pictures.saving.is_busy, "the file")
    assert room_session.messages.text == "no room"
