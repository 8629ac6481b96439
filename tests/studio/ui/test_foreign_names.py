"""Names from files are shown without control characters."""

from collections.abc import Iterator

import pytest
from imgui_bundle import imgui

from heatlens.core.base.outside_text import printable
from heatlens.studio.settings.preferences import Preferences
from support.command_line import CAMERA, channels
from support.exr_files import rgb, write_file
from support.gltf_files import GltfWriter
from support.gui import Gui, gui_of

UNPRINTABLE_NAME = "a\x1b[2J\rb\u202ec"
_SHOWING = (
    *("text", "text_disabled", "text_wrapped", "text_colored", "selectable", "set_tooltip"),
    *("menu_item", "begin_menu", "begin_combo", "button", "checkbox", "separator_text"),
)


@pytest.fixture
def escaped(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Return all texts that ImGui is given to show."""
    texts: list[str] = []
    for name in _SHOWING:
        original = getattr(imgui, name)

        def spy(*args: object, original: object = original, **options: object) -> object:
            texts.extend(arg.partition("##")[0] for arg in args if isinstance(arg, str))
            return original(*args, **options)  # type: ignore[operator]

        monkeypatch.setattr(imgui, name, spy)
    add_text = imgui.ImDrawList.add_text

    def spy_on_list(self: object, *args: object, **options: object) -> object:
        texts.extend(arg for arg in args if isinstance(arg, str))
        return add_text(self, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(imgui.ImDrawList, "add_text", spy_on_list)
    yield texts
    assert {text for text in texts if printable(text, keep="\n\t") != text} == set()


def open_lists(gui: Gui, *controls: str) -> None:
    """Open the list of each control, and close it again with Escape."""
    for control in controls:
        gui.click(gui.middle(control))
        gui.frame(2)
        gui.key(imgui.Key.escape)


def test_control_characters_in_names_of_a_plate_are_escaped(ctx, tmp_path, escaped):
    """The name is that of a file, of channels, of layers, of a recent file and in a message."""
    path = tmp_path / f"{UNPRINTABLE_NAME}.exr"
    layers = {
        f"{UNPRINTABLE_NAME}.{name}": values for name, values in rgb(*channels()["Z"].shape).items()
    }
    named = channels() | layers | {f"{UNPRINTABLE_NAME}.Z": channels()["Z"]}
    write_file(path, named, **CAMERA)
    preferences = Preferences()
    preferences.remember_opened(str(path))
    with gui_of(ctx, path, preferences, size=(1280, 1700)) as gui:
        session = gui.session
        imgui.set_window_focus("Source")
        gui.frame(3)
        open_lists(gui, "channel", "colour layer")
        session.messages.notify(f"{UNPRINTABLE_NAME} was read")
        gui.frame(2)
        gui.do("Open...")
        gui.until(lambda: any("x1b[2J" in text for text in escaped), "the name of the file")
        gui.frame(10)
        session.files.commands.open(str(tmp_path / f"{UNPRINTABLE_NAME} is not there.exr"))
        gui.frame(20)
    assert sum("x1b[2J" in text for text in escaped) > 20


def test_control_characters_in_names_of_a_scene_are_escaped(ctx, tmp_path, escaped):
    """The name is that of a node, of a camera and of a marked object."""
    writer = GltfWriter()
    writer.node(name=UNPRINTABLE_NAME, mesh=writer.mesh(), translation=[-0.5, -0.5, 0.0])
    perspective = {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}
    camera = writer.add(
        "cameras", type="perspective", perspective=perspective, name=UNPRINTABLE_NAME
    )
    writer.node(name=UNPRINTABLE_NAME, camera=camera, translation=[0.0, 0.0, 3.0])
    with gui_of(ctx, writer.write(tmp_path / "s.gltf"), size=(1280, 1700)) as gui:
        gui.frame(3)
        imgui.set_window_focus("Source")
        gui.frame(3)
        open_lists(gui, "camera")
        gui.click(gui.middle(f"object {UNPRINTABLE_NAME}"))
        gui.click(gui.middle("mark object"))
        gui.frame(5)
    assert any("x1b[2J" in text for text in escaped)
