"""Tiny shots on disk, and `heatlens export` of them, for tests of the export."""

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
MANY = tuple(range(1001, 1025))
CAMERA = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
QUICK = DefocusSettings(Bokeh.HEAT, Quality.DRAFT)


def write_plate(path: Path, turn: int = 0, size: tuple[int, int] = (WIDTH, HEIGHT), **header: Any):
    """Write the room, `turn` pixels to the right."""
    color, depth = (np.roll(values, turn, axis=1) for values in room(*size))
    named = {n: np.ascontiguousarray(color[..., i], np.float16) for i, n in enumerate("RGB")}
    return write_file(path, named | {"Z": np.ascontiguousarray(depth)}, **(CAMERA | header))


def write_plates(folder: Path, frames=FRAMES, **header: Any) -> str:
    """Write a plate for each frame, no two alike; return their pattern."""
    folder.mkdir(exist_ok=True)
    for frame in frames:
        write_plate(folder / f"plate.{frame}.exr", frame, **header)
    return str(folder / "plate.####.exr")


def shot_of(source: str, frames=FRAMES, defocus: DefocusSettings = QUICK) -> Shot:
    """Focus is pulled all through it, so that no two frames have one lens."""
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
    """Add a key that changes no frame beyond its neighbours, because it is linear."""
    curve = shot.curves.of(LensParameter.FOCUS_DISTANCE)
    key = Key(frame, focus_m, Interpolation.LINEAR)
    return shot.with_curve(LensParameter.FOCUS_DISTANCE, curve.with_key(key))


def write_shot_file(folder: Path, **changes: Any) -> Path:
    """Write plates and a shot of them in `folder`."""
    path = folder / "s.heatlens.json"
    write_shot(path, shot_of(write_plates(folder / "plates"), **changes))
    return path


def exported(capsys, shot: object, out: object, *words: object) -> str:
    """Export, which must succeed; what was said on stderr. Stdout names the result alone."""
    assert main(["export", str(shot), "-o", str(out), *map(str, words)]) == 0
    said = capsys.readouterr()
    assert said.out == f"{out}\n"
    assert all(line.startswith("heatlens: ") for line in said.err.splitlines())
    return said.err


def refused(capsys, shot: object, out: object, *words: object) -> str:
    """Run an export that must fail with code 2, and return its one or two sentences."""
    assert main(["export", str(shot), "-o", str(out), *map(str, words)]) == 2
    said = capsys.readouterr()
    assert said.out == "" and "Traceback" not in said.err
    return said.err.splitlines()[-1]


def files_in(folder: Path) -> dict[str, bytes]:
    """Name and content of every file, hidden ones as well."""
    if not folder.is_dir():
        return {}
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}


def names_of(suffix: str, frames=FRAMES) -> list[str]:
    """Return n.1001.exr and so on."""
    return [f"n.{frame}{suffix}" for frame in frames]


def exr(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Read header and channels."""
    ((header, channels),) = read_parts(path)
    return header, channels


def same_frames(a, b) -> bool:
    """Return whether two EXR files hold the same pixels."""
    first, second = exr(a)[1], exr(b)[1]
    return first.keys() == second.keys() and all(
        np.array_equal(first[name], second[name]) for name in first
    )


def rendered(capsys, shot: Shot, frame: int, path, *words: str):
    """Return what `heatlens render` makes of the shot's lens at a frame."""
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
    said = [f"{name}={value}" for name, value in options.items()]
    assert main(["render", plate, "-o", str(path), *said, *words]) == 0
    capsys.readouterr()
    return path


def written(capsys, shot_file, out, *words: object) -> list[int]:
    """Export once more; which frames were made anew."""
    before = {path: path.stat().st_ino for path in out.parent.glob("*")}
    exported(capsys, shot_file, out, *words)
    anew = [path for path in out.parent.glob("*") if before.get(path) != path.stat().st_ino]
    return sorted(int(path.name.split(".")[1]) for path in anew)
