"""Tiny shots on disk, and `heatlens export` of them, for tests of the export."""

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.camera_header import lens_attributes
from support.exr_files import write_file
from support.plates import room

WIDTH, HEIGHT = 32, 18
FRAMES = (1001, 1002, 1003, 1004, 1005, 1006)
MANY_FRAMES = tuple(range(1001, 1025))
CAMERA = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
QUICK = DefocusSettings(Bokeh.HEAT, Quality.DRAFT)


def write_plate(path: Path, turn: int = 0, size: tuple[int, int] = (WIDTH, HEIGHT), **header: Any):
    """Write a plate of the room, rolled by `turn` pixels to the right."""
    color, depth = (np.roll(values, turn, axis=1) for values in room(*size))
    channels = {n: np.ascontiguousarray(color[..., i], np.float16) for i, n in enumerate("RGB")}
    return write_file(path, channels | {"Z": np.ascontiguousarray(depth)}, **(CAMERA | header))


def write_plates(folder: Path, frames=FRAMES, **header: Any) -> str:
    """Write a different plate for each frame. Return their pattern."""
    folder.mkdir(exist_ok=True)
    for frame in frames:
        write_plate(folder / f"plate.{frame}.exr", frame, **header)
    return str(folder / "plate.####.exr")


def shot_of(source: str, frames=FRAMES, defocus: DefocusSettings = QUICK) -> Shot:
    """Return a shot with a focus pull over all frames, so that each frame has another lens."""
    shot = Shot(
        Lens(50.0, 1.4, 1.0, 36.0),
        defocus,
        source,
        frames=FrameRange(frames[0], frames[-1]),
        frames_per_second=24.0,
    )
    for frame, focus_m in ((frames[0], 0.9), (frames[-1], 3.0)):
        shot = with_focus(shot, frame, focus_m)
    return shot


def with_focus(shot: Shot, frame: int, focus_m: float) -> Shot:
    """Add a linear focus key, which changes only the frames between its neighbor keys."""
    curve = shot.curves.of(LensParameter.FOCUS_DISTANCE)
    key = Key(frame, value=focus_m, interpolation=Interpolation.LINEAR)
    return shot.with_curve(LensParameter.FOCUS_DISTANCE, curve.with_key(key))


def write_shot_file(folder: Path, **changes: Any) -> Path:
    """Write plates and a shot of them in `folder`."""
    path = folder / "s.heatlens.json"
    write_shot(path, shot_of(write_plates(folder / "plates"), **changes))
    return path


def export_shot(capsys, shot: object, out: object, *words: object) -> str:
    """Run `heatlens export`, which must succeed and print only `out`. Return its stderr."""
    assert main(["export", str(shot), "-o", str(out), *map(str, words)]) == 0
    captured = capsys.readouterr()
    assert captured.out == f"{out}\n"
    assert all(line.startswith("heatlens: ") for line in captured.err.splitlines())
    return captured.err


def refused_export_message(capsys, shot: object, out: object, *words: object) -> str:
    """Run `heatlens export`, which must fail with code 2. Return the last line of its stderr."""
    assert main(["export", str(shot), "-o", str(out), *map(str, words)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and "Traceback" not in captured.err
    return captured.err.splitlines()[-1]


def files_in(folder: Path) -> dict[str, bytes]:
    """Return name and content of every file in a folder, hidden ones as well.

    A file that is renamed or removed meanwhile, as those of a running export are, is left out.
    """
    files = {}
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        with suppress(FileNotFoundError):
            files |= {path.name: path.read_bytes()} if path.is_file() else {}
    return files


def names_of(suffix: str, frames=FRAMES) -> list[str]:
    """Return the file names n.1001.exr and so on, one per frame."""
    return [f"n.{frame}{suffix}" for frame in frames]


def exr(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Read the header and the channels of an EXR with one part."""
    ((header, channels),) = read_parts(path)
    return header, channels


def same_frames(a, b) -> bool:
    """Return whether two EXR files hold the same pixels."""
    first, second = exr(a)[1], exr(b)[1]
    return first.keys() == second.keys() and all(
        np.array_equal(first[name], second[name]) for name in first
    )


def render_frame_of_shot(capsys, shot: Shot, frame: int, path, *words: str):
    """Run `heatlens render` on the plate and lens of a frame of the shot. Return `path`."""
    lens, defocus = shot.lens_at(frame), shot.defocus
    options = {
        "--focal-length": lens.focal_length_mm,
        "--sensor-width": lens.sensor_width_mm,
        "--f-stop": lens.f_stop,
        "--focus-distance": repr(lens.focus_distance_m),
        "--bokeh": defocus.bokeh,
        "--quality": defocus.quality,
        "--proxy": defocus.proxy,
    }
    plate = shot.source.replace("####", str(frame))
    option_words = [f"{name}={value}" for name, value in options.items()]
    assert main(["render", plate, "-o", str(path), *option_words, *words]) == 0
    capsys.readouterr()
    return path


def export_and_list_new_frames(capsys, shot_file, out, *words: object) -> list[int]:
    """Run an export again. Return the frames whose files were written anew."""
    inodes_before = {path: path.stat().st_ino for path in out.parent.glob("*")}
    export_shot(capsys, shot_file, out, *words)
    new_paths = [
        path for path in out.parent.glob("*") if inodes_before.get(path) != path.stat().st_ino
    ]
    return sorted(int(path.name.split(".")[1]) for path in new_paths)
