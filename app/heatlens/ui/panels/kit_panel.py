"""The lens kit: which one the lens is from, and which of its lenses is on the camera."""

from imgui_bundle import imgui

from heatlens.model.lens_kit import LensKit
from heatlens.printable import printable
from heatlens.session.kit_commands import KitCommands
from heatlens.ui import widgets

_NONE = "none: any lens"


def kit_panel(kit: LensKit | None, commands: KitCommands) -> None:
    """Draw the choice of the kit and of its lens, and what that lens can do."""
    imgui.separator_text("Lens kit")
    tip = "Lenses that belong together. They bound length, f-stop and focus."
    shown = _NONE if kit is None else kit.name
    picked = widgets.choice("kit", shown, [_NONE, *commands.names], tip)
    if picked != shown:
        commands.choose(None if picked == _NONE else picked)
        return
    mounted = commands.mounted
    if kit is None or mounted is None:
        return
    names = [lens.name for lens in kit.lenses]
    name = widgets.choice("lens", mounted.name, names, printable(kit.words))
    if name != mounted.name:
        commands.mount(kit.lenses[names.index(name)])
    imgui.text_disabled(mounted.words)
