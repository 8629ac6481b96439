"""The start screen: its cards, how they are chosen, and commands while nothing is open."""

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
from heatlens.studio.settings.cards import Card, word_of
from heatlens.studio.settings.preferences import Preferences, PreferenceValues
from heatlens.studio.settings.start import Start
from heatlens.studio.ui.start import start_screen
from heatlens.studio.ui.start.start_card import lay_out
from heatlens.studio.ui.start.start_screen import hint_of
from support.commands import listed_commands
from support.gui import Gui, gui_of
from support.session_files import LENS, QUICK, room_file

K = imgui.Key
STILL = str(data_dir("assets") / "still_life.exr")


@pytest.fixture
def start_gui(ctx):
    """Return a function that opens windows without a plate, and close them afterwards."""
    made = []

    def begin(preferences=None, size=(1280, 800), source="", **start):
        before, context = imgui.get_current_context(), imgui.create_context()
        imgui.set_current_context(context)
        gui = Gui(ctx, Start(str(source), defocus=QUICK, **start), size, preferences)
        made.append((gui, context, before))
        gui.until(lambda: not gui.session.files.recent.is_checking, "the recent files")
        gui.frame(3)
        return gui

    yield begin
    for gui, context, before in reversed(made):
        gui.close()
        imgui.destroy_context(context)
        if before is not None:
            imgui.set_current_context(before)


def preferences_with_recent(*files: object) -> Preferences:
    return Preferences(PreferenceValues(recent=tuple(str(file) for file in files)))


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


INPUT_METHODS = ["click", "digit", "arrows"]

# What it offers


@pytest.mark.parametrize("source", ["", "a file"])
def test_panels_show_no_lens_before_a_source_is_read(start_gui, monkeypatch, tmp_path, source):
    """Otherwise the lens would show f/2.8 and jump to that of the source once it is read."""
    with monkeypatch.context() as patch:
        patch.setattr(SourceOpener, "poll", lambda _: None)
        gui = start_gui(source=source and room_file(tmp_path / "room.exr"))
        assert "f-stop" not in gui.drawn and gui.session.source.plate is None
    if source:
        gui.opened()
        assert "f-stop" in gui.drawn


def test_start_screen_offers_demo_still_life_and_open(start_gui):
    gui = start_gui()
    assert titles(gui) == ["Demo scene", "Still life", "Open ..."]
    assert gui.session.source.plate is None and gui.session.source.opener.opening is None


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_start_screen_hint_fits_at_any_scale(start_gui, scale):
    gui = start_gui()
    gui.session.preferences.change(ui_scales={"": scale})
    gui.frame(4)
    x0, y0, x1, y1 = gui.rect("start hint")
    card = gui.rect("start Open ...")
    assert x0 >= card[0] and x1 <= card[2] + 1 and y0 >= card[3]
    assert y1 <= imgui.internal.find_window_by_name("Picture").inner_rect.max.y
    assert (y1 - y0 > 1.5 * gui.ui.scale.em) == (scale == 2.0)  # in two lines


def test_start_screen_lists_existing_recent_files(start_gui, tmp_path):
    plate, shot = room_file(tmp_path / "room.exr"), tmp_path / "a.heatlens.json"
    shot.write_text(json.dumps({}))
    gui = start_gui(preferences_with_recent(plate, tmp_path / "gone.exr", STILL, shot))
    recent_cards = [
        (card.title, card.kind, card.text) for card in gui.session.files.start_choices.cards()[3:]
    ]
    assert recent_cards == [("room.exr", "Plate", str(plate)), (shot.name, "Shot", str(shot))]


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
def test_word_of_names_the_kind_of_a_file(name, kind):
    assert word_of(name) == kind


# Choosing


@pytest.mark.parametrize("how", INPUT_METHODS)
def test_demo_card_opens_the_demo(start_gui, small_demo, how):
    gui = start_gui()
    choose(gui, how, 0)
    gui.opened()
    assert gui.session.facts.shot.source == "demo" and gui.session.facts.has_camera
    assert not gui.session.files.start_choices.is_shown
    assert gui.session.preferences.values.recent == ()  # it has a place of its own


@pytest.mark.parametrize("how", INPUT_METHODS)
def test_recent_card_opens_its_plate(start_gui, tmp_path, how):
    plates = [room_file(tmp_path / name) for name in ("a.exr", "b.exr")]
    gui = start_gui(preferences_with_recent(*plates))
    choose(gui, how, 4)
    gui.opened()
    assert gui.session.facts.shot.source == str(plates[1]) and gui.session.facts.lens == LENS


def test_only_the_card_of_the_shot_being_opened_is_marked(start_gui, tmp_path, monkeypatch):
    plate = room_file(tmp_path / "room.exr")
    shot = tmp_path / "pull.heatlens.json"
    write_shot(shot, Shot(LENS, source=str(plate)))
    gui = start_gui(preferences_with_recent(shot, plate))
    marked_titles, draw_card = [], start_screen.draw_card
    monkeypatch.setattr(
        start_screen,
        "draw_card",
        lambda card, *rest: (
            (marked_titles.append(card.title) if rest[-1] else None) or draw_card(card, *rest)
        ),
    )
    choose(gui, "digit", titles(gui).index(shot.name))
    gui.opened()
    assert set(marked_titles) == {shot.name}


@pytest.mark.parametrize("how", INPUT_METHODS)
def test_open_card_opens_the_file_dialog(start_gui, how):
    gui = start_gui()
    choose(gui, how, 2)
    gui.until(lambda: gui.ui.dialogs.is_open, "the dialog")
    gui.key(K._1)  # of the dialog now
    gui.key(K.escape)
    gui.frame(3)
    assert not gui.ui.dialogs.is_open
    assert gui.session.files.start_choices.is_shown and gui.session.source.opener.opening is None


def test_start_screen_reports_a_broken_file_and_stays(start_gui, tmp_path):
    broken, plate = tmp_path / "broken.exr", room_file(tmp_path / "room.exr")
    broken.write_bytes(b"no exr")
    gui = start_gui(preferences_with_recent(broken, plate))
    choose(gui, "digit", 3)
    gui.until(lambda: "broken.exr" in gui.session.messages.text, "the refusal")
    assert gui.session.files.start_choices.is_shown
    gui.session.messages._shown_since -= 3600.0  # an hour later it is still there to be read
    gui.frame(2)
    assert "broken.exr" in gui.session.messages.text
    choose(gui, "digit", 4)
    assert not gui.session.messages.text
    gui.opened()
    assert gui.session.facts.shot.source == str(plate)


# Nothing is open


def test_keys_of_the_picture_do_nothing_on_the_start_screen(start_gui):
    gui = start_gui()
    shot, view = gui.session.facts.shot, gui.session.facts.view
    for key in (K.escape, K.k, K.space, K.left_bracket, K.d, K.f, K.m, K.up_arrow, K.left_arrow):
        gui.key(key)
    assert (gui.session.facts.shot, gui.session.facts.view) == (shot, view)
    assert gui.session.files.start_choices.is_shown and gui.session.source.opener.opening is None


def test_every_command_runs_without_an_open_source(start_gui):
    gui = start_gui(size=(640, 400))
    for action in listed_commands():
        if action.name in ("Quit", "Open the demo"):
            continue
        gui.do(action.name)
        for _ in range(2):
            gui.key(K.escape)
        gui.frame()
        assert gui.session.source.plate is None, action.name


# Back to it


def test_menu_opens_the_start_screen_and_escape_leaves_it(ctx, tmp_path):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as gui:
        gui.settled()
        screen_before, shot = gui.screenshot(), gui.session.facts.shot
        gui.do("Start screen")
        assert gui.session.files.start_choices.is_shown and "start Demo scene" in gui.drawn
        gui.key(K.escape)
        gui.frame(3)
        assert not gui.session.files.start_choices.is_shown and gui.session.facts.shot == shot
        assert abs(gui.screenshot().astype(int) - screen_before).max() <= 1


def test_start_screen_offers_the_stream_of_a_renderer(start_gui):
    stream = StreamSource("127.0.0.1", 0)
    gui = start_gui(source=stream.text, stream=stream)
    gui.do("Start screen")
    assert titles(gui)[3] == "Listen to a renderer"
    choose(gui, "digit", 3)
    gui.frame(2)
    assert gui.session.source.is_waiting and not gui.session.files.start_choices.is_shown


# How it looks


@given(
    st.integers(3, 4),
    st.integers(0, 6),
    st.tuples(st.floats(100, 3000), st.floats(280, 2000)),
    st.sampled_from([12.0, 15.0]),
)
def test_start_screen_layout_neither_overlaps_nor_leaves_the_screen(cards, recent, size, em):
    layout = lay_out(cards, recent, size, em)
    first, others = layout.cards[:cards], layout.cards[cards:]
    bands = [layout.head, *first, layout.hint, *others]
    assert all(a.end <= b.y + 1e-6 for a, b in pairwise(bands))
    assert layout.head.y >= 0 and bands[-1].end <= max(size[1], layout.hint.end)
    assert layout.x >= 0 and layout.x + layout.width <= size[0] + 1e-6
    assert layout.hint.end <= size[1] or size[1] < 26 * em


@pytest.mark.parametrize("size", [(1280, 800), (1600, 900), (800, 500)])
def test_start_screen_cards_lie_inside_the_picture_area(start_gui, tmp_path, size):
    files = [room_file(tmp_path / f"{name}.exr") for name in "abcdefgh"]
    gui = start_gui(preferences_with_recent(*files), size)
    left, top, right, bottom = gui.rect("picture")
    shown = [f"start {title}" for title in titles(gui)]
    assert len(shown) == 9
    rects = [gui.drawn[name] for name in shown[: 9 if size[1] >= 800 else 6]]
    for x0, y0, x1, y1 in rects:
        assert left <= x0 < x1 <= right and top <= y0 < y1 <= bottom
    assert len({(x0, x1) for x0, _, x1, _ in rects}) == 1  # one left edge, one right edge


# From the command line


def test_command_without_a_file_starts_without_a_source(monkeypatch):
    starts = []
    monkeypatch.setattr("heatlens.studio.ui.window.run_window", starts.append)
    assert main([]) == 0 and main(["view", "--f-stop", "4"]) == 0
    assert [start.source for start in starts] == ["", ""]
    assert starts[1].lens == {"f_stop": 4.0}


def test_view_refuses_an_empty_name(capsys, monkeypatch):
    monkeypatch.setattr(
        "heatlens.studio.ui.window.run_window", lambda start: pytest.fail("a window")
    )
    assert main(["view", ""]) == 2
    assert "empty" in capsys.readouterr().err


def test_pictures_of_the_start_cards_are_assets(start_gui):
    pictures = [
        card.picture for card in start_gui().session.files.start_choices.cards() if card.picture
    ]
    assert len(pictures) == 2
    assert all(Path(data_dir("assets") / name).is_file() for name in pictures)


def test_start_hint_mentions_space_only_for_sources_with_frames():
    assert "Space" in hint_of(Card("Demo scene", "", DEMO))
    assert "Space" in hint_of(Card("shot.####.exr", "", "shot.####.exr", "Sequence"))
    for card in (Card("Still life", "", "still_life.exr"), Card("a.exr", "", "a.exr", "Plate")):
        assert "Space" not in hint_of(card) and "click" in hint_of(card)
