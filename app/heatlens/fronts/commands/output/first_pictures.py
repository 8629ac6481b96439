"""Render example pictures when `heatlens` is started without arguments and without a display."""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

import heatlens
from heatlens.core.base.errors import NoWindowError
from heatlens.core.base.paths import data_dir
from heatlens.core.base.system_packages import quoted
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.color.color_config import load_color_config
from heatlens.media.color.view_transform import ViewTransform, view_transform
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.files.picture_encoding import encode_picture
from heatlens.media.plate.picture.picture_write import write_png
from heatlens.media.scene.demo import demo_shot
from heatlens.media.scene.scene_read import DEMO

_STILL, _PULL = "heatlens_still_life.png", "heatlens_pull.webp"
_FRUIT = (290, 190)  # the pixel of the still life to focus on
_FRAMES, _SIZE = 4, (320, 180)  # frames of the focus pull: a few seconds on a CPU
_F_STOP = 1.2  # wider than in the demo, so that the pull is visible in a small picture
_MILLISECONDS = 480  # duration of each frame


def make_first_pictures(error: NoWindowError) -> int:
    """Render example pictures into the current folder, and print commands to continue with.

    Raises GpuError if nothing can draw here.
    """
    print_messages(str(error).partition(". ")[0] + ", so here are pictures instead.")
    folder, plate = _writable_folder(), data_dir("assets") / "still_life.exr"
    view = _default_view()
    still, pull = folder / _STILL, folder / _PULL
    picture = heatlens.open(plate).render(focus_at=_FRUIT)
    write_png(still, picture[..., :3], encode=view.apply_cpu)
    print(f"{still}    the still life, focus on the fruit", flush=True)
    write_atomically(pull, _animation(list(_render_frames(view))))
    print(f"{pull}    the street at night, the focus pulled from one walker to the next")
    command, plate_name = start_command(), quoted(str(_relative_path(plate)))
    print(
        "\nGo on with these, or with a plate or scene of your own:\n"
        f"  {command} render {plate_name} -o lights.png --focus-at 330,60\n"
        f"  {command} render demo -o street.png --frame 120 --f-stop 1.4\n"
        f"  {command} export demo -o street/####.png --frames 60-90 --size 640x360\n"
        f"  {command} render --help"
    )
    return 0


def start_command() -> str:
    """Return the words that start this program again in the shell, as short as they can be."""
    program = Path(sys.argv[0])
    if program.name == "__main__.py":
        return f"{quoted(sys.orig_argv[0])} -m heatlens"
    on_path = shutil.which(program.name)
    if on_path is not None and os.path.realpath(on_path) == os.path.realpath(program):
        return program.name
    return quoted(str(_relative_path(program)))


def _relative_path(path: Path) -> Path:
    """Return a path relative to the current folder if it is inside that folder."""
    current_folder = Path.cwd()
    return path.relative_to(current_folder) if path.is_relative_to(current_folder) else path


def _writable_folder() -> Path:
    """Return the current folder, or a temporary one if it is not writable."""
    current_folder = Path.cwd()
    return (
        current_folder
        if os.access(current_folder, os.W_OK)
        else Path(tempfile.mkdtemp(prefix="heatlens-"))
    )


def _default_view() -> ViewTransform:
    """Return the view transform of the default display and view."""
    config = load_color_config(path=None)
    display, view = config.default_display, config.default_view
    return view_transform(config, display, view, config.default_input_space)


def _render_frames(view: ViewTransform) -> Iterator[Image.Image]:
    """Render the first pull of the demo; show the progress on a terminal."""
    start, end = demo_shot().key_frames[:2]
    source = heatlens.open(DEMO, size=_SIZE)
    with progress_line() as show:
        for number, frame in enumerate(np.linspace(start, end, _FRAMES), start=1):
            show(f"frame {number} of {_FRAMES}")
            light = source.render(frame=round(float(frame)), f_stop=_F_STOP, quality="preview")
            display_values = np.clip(view.apply_cpu(light[..., :3]), 0.0, 1.0)
            yield Image.fromarray((display_values * 255 + 0.5).astype(np.uint8))


def _animation(frames: list[Image.Image]) -> bytes:
    """Encode the frames as a WebP that plays forwards and backwards, repeated forever."""
    other_frames = [*frames[1:], *frames[-2:0:-1]]
    options = {"append_images": other_frames, "duration": _MILLISECONDS, "loop": 0, "quality": 85}
    return encode_picture(frames[0], "WEBP", save_all=True, **options)
