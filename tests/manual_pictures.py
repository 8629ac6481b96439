"""Draw the pictures of the window in README.md and of panels in app/manual.

    .venv/bin/python tests/manual_pictures.py

The window is drawn without a display: the tabs of `OF_SCENE` with the demo, the others with the
still life.
"""

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui
from PIL import Image

from heatlens.core.model.marks.marks import DistanceMark
from heatlens.media.scene.scene_read import DEMO
from heatlens.render.gpu.context import headless_context
from heatlens.render.gpu.device import Device
from support.gui import Gui, gui_of

ASSETS = Path(__file__).parents[1] / "assets"
SIZE, SCALE = (1500, 2100), 1.25
_MARGIN = 52  # of a panel around its controls, in screen units
COLORS = 96  # few enough for small files; panels have flat colours
# The file of a picture and the panel that it shows.
OF_PLATE = {"lens": "Lens", "source": "Source", "display": "Display", "export": "Export"}
OF_PLATE |= {"looks": "Looks"}
OF_SCENE = {"scene": "Source", "timeline": "Timeline"}
LOW, FROM_ABOVE = (1500, 1000), {"marks": "Marks"}  # its plan fills it
WINDOW = (1600, 900)
MARKS = (DistanceMark("A", 1.193), DistanceMark("B", 1.95))  # an apple, and the wall behind it
FOLDS = {"Display": ("Frame masks and guides", "frame mask")}


def panel_picture(gui: Gui, name: str) -> Image.Image:
    """Return what the window shows of a panel, from its tab to its last control."""
    imgui.set_window_focus(name)
    gui.frame(2)
    if name in FOLDS:
        gui.unfolded(*FOLDS[name])
    exports = gui.session.files.exports
    exports.settings = replace(exports.settings, folder="~/shots/still_life")
    gui.frame(2)
    window = imgui.internal.find_window_by_name(name)
    x0, y0 = window.pos.x, window.pos.y
    width, height = window.size.x, min(window.size.y, window.content_size.y + _MARGIN)
    box = [round(SCALE * value) for value in (x0, y0, x0 + width, y0 + height)]
    return Image.fromarray(gui.screenshot().copy()).crop(tuple(box))


def write_window_picture(ctx: Device) -> None:
    """Write assets/window.png: the window with the still life, two marks and the Lens panel."""
    with gui_of(ctx, ASSETS / "still_life.exr", size=WINDOW) as gui:
        gui.session.editing.begin(replace(gui.session.facts.shot, marks=MARKS))
        imgui.set_window_focus("Lens")
        gui.settled()
        gui.click(gui.middle("dismiss lessons"))  # the hints of a first start
        gui.settled()
        path = ASSETS / "window.png"
        Image.fromarray(gui.screenshot().copy()).save(path, optimize=True)
        print(path, path.stat().st_size)


def main() -> None:
    """Write the pictures to assets and assets/manual."""
    folder = ASSETS / "manual"
    folder.mkdir(exist_ok=True)
    ctx = headless_context()
    write_window_picture(ctx)
    shots = Path(tempfile.gettempdir()) / "shots"  # the folder that the Source tab shows
    shots.mkdir()  # never one that is there already, for it is removed in the end
    plate = shutil.copy(ASSETS / "still_life.exr", shots)
    for source, names, size in (
        (plate, OF_PLATE, SIZE),
        (DEMO, OF_SCENE, SIZE),
        (DEMO, FROM_ABOVE, LOW),
    ):
        _write(ctx, source, names, size, folder)
    shutil.rmtree(shots)
    ctx.release()


def _write(
    ctx: Device,
    source: str,
    names: dict[str, str],
    size: tuple[int, int],
    folder: Path,
) -> None:
    with gui_of(ctx, source, size=size, scale=SCALE) as gui:
        if source != DEMO:
            gui.settled()
            gui.do("Keep this look")
        for file, name in names.items():
            path = folder / f"{file}.png"
            panel_picture(gui, name).quantize(COLORS).save(path, optimize=True)
            print(path, path.stat().st_size)


if __name__ == "__main__":
    main()
