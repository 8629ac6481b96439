"""The start screen: what it offers, how it is chosen from, and that nothing needs a picture."""

import json
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.base.paths import data_dir
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.scene.scene_read import DEMO
from heatlens.render.source.opener import SourceOpener
from heatlens.render.source.stream_source import StreamSource
from heatlens.studio.session.files.start_choices import Card, word_of
from heatlens.studio.session.settings.preferences import Preferences, Remembered
from heatlens.studio.session.shot.start import Start
from heatlens.studio.ui.start import start_screen
from heatlens.studio.ui.start.start_card import lay_out
from heatlens.studio.ui.start.start_screen import hint_of
from support.commands import listed_commands
from support.gui import Gui, gui_of
from support.session_files import LENS, QUICK, room_file

K = imgui.Key
STILL = str(data_dir("assets") / "still_life.exr")


@pytest.fixture
def begun(ctx):
    """Return a function that opens windows without a plate, and close them afterwards."""
    made = []

    def begin(preferences=None, size=(1280, 800), source="", **start):
        before, context = imgui.get_current_context(), imgui.create_context()
        imgui.set_current_context(context)
        gui = Gui(ctx, Start(str(source), defocus=QUICK, **start), size, preferences)
        made.append((gui, context, before))
        gui.until(lambda: not gui.session.files.recent.is_looking, "the recent files")
        gui.frame(3)
        return gui

    yield begin
    for gui, context, before in reversed(made):
        gui.close()
        imgui.destroy_context(context)
        if before is not None:
            imgui.set_current_context(before)


def remembered(*files: object) -> Preferences:
    return Preferences(Remembered(recent=tuple(str(file) for file in files)))


def titles(gui: Gui) -> list[str]:
    return [card.title for card in gui.session.files.start_choices.cards()]


def choose(gui: Gui, how: str, row: int) -> None:
    """Choose a card by the mouse, the arrow keys or its digit."""
    if how == "click":
        gui.click(gui.middle(f"start {titles(gui)[row]}"))
    elif how == "digit":
        gui.key(getattr(K, f"_{row + 1}"))
    else:
        for _ in range(row):
            gui.key(K.down_arrow)
        gui.key(K.enter)


HOWS = ["click", "digit", "arrows"]

# What it offers


@pytest.mark.parametrize("source", ["", "a file"])
def test_panels_show_no_values_before_anything_has_come(begun, monkeypatch, tmp_path, source):
    """A lens of f/2.8 would jump to that of the scene as soon as it is read."""
    with monkeypatch.context() as patch:
        patch.setattr(SourceOpener, "poll", lambda _: None)
        gui = begun(source=source and room_file(tmp_path / "room.exr"))
        assert "f-stop" not in gui.drawn and gui.session.source.plate is None
    if source:
        gui.opened()
        assert "f-stop" in gui.drawn


def test_without_a_plate_it_offers_the_demo_the_still_life_and_a_file(begun):
    gui = begun()
    assert titles(gui) == ["Demo scene", "Still life", "Open ..."]
    assert gui.session.source.plate is None and gui.session.source.opener.opening is None


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_the_hint_is_whole_in_large_letters(begun, scale):
    gui = begun()
    gui.session.preferences.change(ui_scales={"": scale})
    gui.frame(4)
    x0, y0, x1, y1 = gui.rect("start hint")
    card = gui.rect("start Open ...")
    assert x0 >= card[0] and x1 <= card[2] + 1 and y0 >= card[3]
    assert y1 <= imgui.internal.find_window_by_name("Picture").inner_rect.max.y
    assert (y1 - y0 > 1.5 * gui.ui.scale.em) == (scale == 2.0)  # in two lines


def test_recent_files_follow_as_far_as_they_are_there(begun, tmp_path):
    plate, shot = room_file(tmp_path / "room.exr"), tmp_path / "a.heatlens.json"
    shot.write_text(json.dumps({}))
    gui = begun(remembered(plate, tmp_path / "gone.exr", STILL, shot))
    found = [
        (card.title, card.kind, card.text) for card in gui.session.files.start_choices.cards()[3:]
    ]
    assert found == [("room.exr", "Plate", str(plate)), (shot.name, "Shot", str(shot))]


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("/a/b.exr", "Plate"),
        ("/a/b.####.exr", "Sequence"),
        ("/a/b.%04d.exr", "Sequence"),
        ("/a/frames", "Sequence"),
        ("/a/b.glb", "3D scene"),
        ("/a/b.heatlens.json", "Shot"),
    ],
)
def test_a_name_tells_what_a_file_is(name, kind):
    assert word_of(name) == kind


# Choosing


@pytest.mark.parametrize("how", HOWS)
def test_the_demo_is_opened_as_the_option_opens_it(begun, small_demo, how):
    gui = begun()
    choose(gui, how, 0)
    gui.opened()
    assert gui.session.facts.shot.source == "demo" and gui.session.facts.has_camera
    assert not gui.session.files.start_choices.is_wanted
    assert gui.session.preferences.now.recent == ()  # it has a place of its own


@pytest.mark.parametrize("how", HOWS)
def test_a_recent_plate_is_opened(begun, tmp_path, how):
    plates = [room_file(tmp_path / name) for name in ("a.exr", "b.exr")]
    gui = begun(remembered(*plates))
    choose(gui, how, 4)
    gui.opened()
    assert gui.session.facts.shot.source == str(plates[1]) and gui.session.facts.lens == LENS


def test_a_shot_that_is_opened_marks_its_own_card(begun, tmp_path, monkeypatch):
    plate = room_file(tmp_path / "room.exr")
    shot = tmp_path / "pull.heatlens.json"
    write_shot(shot, Shot(LENS, source=str(plate)))
    gui = begun(remembered(shot, plate))
    coming, drawn = [], start_screen.draw_card
    monkeypatch.setattr(
        start_screen,
        "draw_card",
        lambda card, *rest: (coming.append(card.title) if rest[-1] else None) or drawn(card, *rest),
    )
    choose(gui, "digit", titles(gui).index(shot.name))
    gui.opened()
    assert set(coming) == {shot.name}


@pytest.mark.parametrize("how", HOWS)
def test_a_file_is_asked_for(begun, how):
    gui = begun()
    choose(gui, how, 2)
    gui.until(lambda: gui.ui.dialogs.is_open, "the dialog")
    gui.key(K._1)  # of the dialog now
    gui.key(K.escape)
    gui.frame(3)
    assert not gui.ui.dialogs.is_open
    assert gui.session.files.start_choices.is_wanted and gui.session.source.opener.opening is None


def test_what_cannot_be_opened_is_said_and_another_choice_can_be_made(begun, tmp_path):
    broken, plate = tmp_path / "broken.exr", room_file(tmp_path / "room.exr")
    broken.write_bytes(b"no exr")
    gui = begun(remembered(broken, plate))
    choose(gui, "digit", 3)
    gui.until(lambda: "broken.exr" in gui.session.messages.text, "the refusal")
    assert gui.session.files.start_choices.is_wanted
    gui.session.messages._said_at -= 3600.0  # an hour later it is still there to be read
    gui.frame(2)
    assert "broken.exr" in gui.session.messages.text
    choose(gui, "digit", 4)
    assert not gui.session.messages.text
    gui.opened()
    assert gui.session.facts.shot.source == str(plate)


# Nothing is open


def test_escape_and_keys_of_the_picture_do_nothing(begun):
    gui = begun()
    shot, view = gui.session.facts.shot, gui.session.facts.view
    for key in (K.escape, K.k, K.space, K.left_bracket, K.d, K.f, K.m, K.up_arrow, K.left_arrow):
        gui.key(key)
    assert (gui.session.facts.shot, gui.session.facts.view) == (shot, view)
    assert gui.session.files.start_choices.is_wanted and gui.session.source.opener.opening is None


def test_every_command_can_be_given(begun):
    gui = begun(size=(640, 400))
    for action in listed_commands():
        if action.name in ("Quit", "Open the demo"):
            continue
        gui.do(action.name)
        for _ in range(2):
            gui.key(K.escape)
        gui.frame()
        assert gui.session.source.plate is None, action.name


# Back to it


def test_the_menu_leads_back_and_escape_to_the_picture_again(ctx, tmp_path):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as gui:
        gui.settled()
        seen, shot = gui.screenshot(), gui.session.facts.shot
        gui.do("Start screen...")
        assert gui.session.files.start_choices.is_wanted and "start Demo scene" in gui.drawn
        gui.key(K.escape)
        gui.frame(3)
        assert not gui.session.files.start_choices.is_wanted and gui.session.facts.shot == shot
        assert abs(gui.screenshot().astype(int) - seen).max() <= 1


def test_a_renderer_that_is_listened_to_can_be_chosen(begun):
    stream = StreamSource("127.0.0.1", 0)
    gui = begun(source=stream.text, stream=stream)
    gui.do("Start screen...")
    assert titles(gui)[3] == "Listen to a renderer"
    choose(gui, "digit", 3)
    gui.frame(2)
    assert gui.session.source.is_waiting and not gui.session.files.start_choices.is_wanted


# How it looks


@given(
    st.integers(3, 4),
    st.integers(0, 6),
    st.tuples(st.floats(100, 3000), st.floats(280, 2000)),
    st.sampled_from([12.0, 15.0]),
)
def test_nothing_overlaps_or_is_cut_off(cards, recent, room, em):
    layout = lay_out(cards, recent, room, em)
    first, others = layout.cards[:cards], layout.cards[cards:]
    bands = [layout.head, *first, layout.hint, *others]
    assert all(a.end <= b.y + 1e-6 for a, b in pairwise(bands))
    assert layout.head.y >= 0 and bands[-1].end <= max(room[1], layout.hint.end)
    assert layout.x >= 0 and layout.x + layout.width <= room[0] + 1e-6
    assert layout.hint.end <= room[1] or room[1] < 26 * em


@pytest.mark.parametrize("size", [(1280, 800), (1600, 900), (800, 500)])
def test_cards_lie_inside_the_picture_and_six_recent_files_where_there_is_room(
    begun, tmp_path, size
):
    files = [room_file(tmp_path / f"{name}.exr") for name in "abcdefgh"]
    gui = begun(remembered(*files), size)
    left, top, right, bottom = gui.rect("picture")
    shown = [f"start {title}" for title in titles(gui)]
    assert len(shown) == 9
    rects = [gui.drawn[name] for name in shown[: 9 if size[1] >= 800 else 6]]
    for x0, y0, x1, y1 in rects:
        assert left <= x0 < x1 <= right and top <= y0 < y1 <= bottom
    assert len({(x0, x1) for x0, _, x1, _ in rects}) == 1  # one left edge, one right edge


# From the command line


def test_the_command_alone_names_no_plate(monkeypatch):
    starts = []
    monkeypatch.setattr("heatlens.studio.ui.window.run_window", starts.append)
    assert main([]) == 0 and main(["view", "--f-stop", "4"]) == 0
    assert [start.source for start in starts] == ["", ""]
    assert starts[1].lens == {"f_stop": 4.0}


def test_an_empty_name_is_no_wish_for_the_start_screen(capsys, monkeypatch):
    monkeypatch.setattr(
        "heatlens.studio.ui.window.run_window", lambda start: pytest.fail("a window")
    )
    assert main(["view", ""]) == 2
    assert "empty" in capsys.readouterr().err


def test_pictures_on_the_cards_come_with_the_program(begun):
    pictures = [
        card.picture for card in begun().session.files.start_choices.cards() if card.picture
    ]
    assert len(pictures) == 2
    assert all(Path(data_dir("assets") / name).is_file() for name in pictures)


def test_space_is_only_spoken_of_where_there_is_something_to_play():
    assert "Space" in hint_of(Card("Demo scene", "", DEMO))
    assert "Space" in hint_of(Card("shot.####.exr", "", "shot.####.exr", "Sequence"))
    for card in (Card("Still life", "", "still_life.exr"), Card("a.exr", "", "a.exr", "Plate")):
        assert "Space" not in hint_of(card) and "click" in hint_of(card)
