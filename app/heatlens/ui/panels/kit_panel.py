"""Draw the choice of a lens kit and of the lens on the camera."""

from imgui_bundle import imgui

from heatlens.base.printable import printable
from heatlens.model.lens import Lens
from heatlens.model.lens_kit import LensKit
from heatlens.session.lens.kit_commands import KitCommands
from heatlens.ui import widgets

_BREATHING_TIP = "At close focus the lens shows {:.3g} % of the width that it shows at infinity."
_NONE = "none: any lens"


def kit_panel(kit: LensKit | None, lens: Lens, commands: KitCommands) -> None:
    """Draw the choice of the kit and of its lens, and the limits of that lens."""
    tip = "A set of lenses. It limits focal length, f-stop and focus."
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
    if mounted.breathing != 1.0:
        breathes, tip = lens.breathing != 1.0, _BREATHING_TIP.format(100 * mounted.breathing)
        if widgets.check("the view breathes", breathes, "breathing", tip) != breathes:
            commands.breathe(not breathes)
