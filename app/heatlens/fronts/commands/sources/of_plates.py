"""Plates on the command line."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, FrameRange
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.marks.marks import MatteMark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.options.lens_options import lens_of, plate_options, shot_with_kit
from heatlens.fronts.commands.output.pipes import file_of_input
from heatlens.fronts.commands.output.plate_words import print_plate_notes
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import print_messages
from heatlens.fronts.commands.output.thing_words import thing_lines
from heatlens.fronts.commands.sources.shot_plate import plate_shot
from heatlens.fronts.commands.sources.source_commands import Facts, Line, SourceCommands
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.color.color_config import PLAIN_OCIO_VIEW
from heatlens.media.frame_cache.sequence_reader import (
    NeighbourReader,
    SequenceReader,
    fix_conventions,
)
from heatlens.media.plate.exr.exr_write import behind_path, write_behind
from heatlens.media.plate.header.timecode import rate_at
from heatlens.media.plate.inspection import inspect
from heatlens.media.plate.mattes.things import require_thing, require_things
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from heatlens.media.plate.tracking.tracked_mark import track_mark
from heatlens.media.sequence.names import frames_text
from heatlens.media.sequence.sequence import find_sequence
from heatlens.render.defocus.quality import unused_behind_notes

if TYPE_CHECKING:
    from heatlens.render.frame_renderer import FrameRenderer  # `info` draws nothing
_CAMERA_LINES = (
    ("focal length", "focal_length_mm", "mm"),
    ("f-stop", "f_stop", ""),
    ("T-stop", "t_stop", ""),
    ("focus distance", "focus_distance_m", "m"),
    ("sensor width", "sensor_width_mm", "mm"),
    ("sensor height", "sensor_height_mm", "mm"),
    ("lens model", "model", ""),
)
_DISPLAY_REFERRED_VIEW = (
    f"{PLAIN_OCIO_VIEW}, if the config has it, unless --view is given: the picture is "
    "display-referred, and its tones are mapped already"
)


class PlateCommands(SourceCommands):
    """Reads plates, whose lens may be in the header."""

    def load(
        self, args: argparse.Namespace, renderer: "FrameRenderer", settings: DefocusSettings
    ) -> tuple[Shot, int]:
        """Load one plate, and return its shot."""
        if settings.method.needs_scene:
            raise InputError(
                f"{args.plate} is a plate, seen from one point: --method {settings.method} needs "
                "a 3D scene, seen from many."
            )
        options = plate_options(args)
        plate = _read_plate_with_neighbours(
            Path(args.plate), options, getattr(args, "behind_out", None)
        )
        lens, lens_sentence = lens_of(args, plate)
        print_plate_notes(plate, lens, lens_sentence, options)
        print_messages(*unused_behind_notes(plate, settings))
        renderer.load(plate)
        return shot_with_kit(args, Shot(lens, settings)), 0

    def shot(self, args: argparse.Namespace) -> Shot:
        """Return a shot with a constant lens of the options and of the first plate's header.

        It does not depend on the requested frames, because a shot may be exported in parts.
        """
        sequence, options = find_sequence(args.shot), plate_options(args)
        plate = read_plate(sequence.path_at(sequence.present[0]), options)
        lens, lens_sentence = lens_of(args, plate)
        print_plate_notes(plate, lens, lens_sentence, options)
        shot = Shot(
            lens,
            source=args.shot,
            plate_options=fix_conventions(options, plate),
            frames_per_second=rate_at(plate.attributes) or FRAMES_PER_SECOND,
        )
        return shot_with_kit(args, shot)

    def new_shot(self, args: argparse.Namespace, camera: CameraSamples | None) -> Shot:
        """Return a shot with the files, lens, frames and frame rate of the plates."""
        shot = plate_shot(args, camera)
        for file in _first_files(args):
            require_things(file, plate_options(args))
        return shot

    def track_mark(self, args: argparse.Namespace, shot: Shot, mark: TrackMark) -> TrackMark:
        """Read the plates and follow the surface of the mark."""
        frames, plate_at = _plate_reader_of(args, shot)
        with progress_line() as show_progress:
            return track_mark(mark, frames, plate_at, show_progress)

    def check_thing(self, args: argparse.Namespace, mark: MatteMark) -> None:
        """Raise InputError where no plate has the thing of a mark."""
        for file in _first_files(args):
            require_thing(file, mark.matte)

    def info(self, args: argparse.Namespace, text: str) -> tuple[Facts, list[Line]]:
        """Return the contents of the file, and how it would be read."""
        with file_of_input(Path(text)) as path:
            facts = inspect(path, plate_options(args))
        return facts, plate_lines(facts)


def _first_files(args: argparse.Namespace) -> tuple[Path, ...]:
    """Return a tuple with the first file, or an empty tuple if no plate is rendered yet."""
    try:
        sequence = find_sequence(args.plate)
    except InputError:  # reported already, when the shot was made
        return ()
    return (sequence.path_at(sequence.present[0]),)


def _plate_reader_of(
    args: argparse.Namespace, shot: Shot
) -> tuple[FrameRange, Callable[[int], Plate]]:
    """Return the frames of a shot, and a function that reads the plate of a frame.

    For a missing plate, the function reads the one before.
    """
    sequence = find_sequence(args.plate)
    reader = SequenceReader(shot.plate_options, sequence.path_at(sequence.present[0]))

    def plate_at(frame: int) -> Plate:
        shown_frame = sequence.shown_frame(frame, "hold")
        assert shown_frame is not None  # a sequence that was found has a file
        return reader(sequence.path_at(shown_frame))

    return shot.frames or FrameRange(sequence.first, sequence.last), plate_at


def _read_plate_with_neighbours(
    path: Path, options: PlateOptions, behind_out: Path | None
) -> Plate:
    """Read a plate; with --neighbours, add the hidden surfaces that neighboring frames show.

    The hidden surfaces are also written to `behind_out`, if it is given. Raises InputError if a
    file cannot be read or written.
    """
    if not options.neighbours:
        if behind_out is not None:
            raise InputError("--behind-out writes what neighbouring frames show: add --neighbours.")
        return read_plate(path, options)
    target = None if behind_out is None else behind_path(behind_out, path)
    reader = NeighbourReader(options, find_sequence(path))
    found_surfaces = reader.add_hidden_surfaces(reader.read_alone(path))
    print_messages(reader.neighbourhood.words)
    if found_surfaces.frames:
        frame_list = frames_text(found_surfaces.frames)
        print_messages(
            f"frames {frame_list} show {found_surfaces.hidden_part:.0%} of what near silhouettes "
            "could hide."
        )
    if target is not None:
        write_behind(target, found_surfaces.layers)
        print_messages(f"{target} shows what lies behind {path}.")
    return found_surfaces.plate


def plate_lines(facts: Facts) -> list[Line]:
    """Return the facts of `inspect` as text, each with a label."""
    return [
        ("file", facts["path"]),
        ("size", f"{facts['width_px']} x {facts['height_px']} px"),
        ("data window", _window_text(facts["data_window"])),
        ("display window", _window_text(facts["display_window"])),
        ("pixel aspect", f"{facts['pixel_aspect_ratio']:g}"),
        *([("views", ", ".join(facts["views"]))] if facts["views"] else []),
        *_part_lines(facts["parts"]),
        *thing_lines(facts["things"]),
        *_camera_lines(facts["camera"]),
        *_primaries_lines(facts["primaries"]),
        *([("seen through", _DISPLAY_REFERRED_VIEW)] if facts["is_for_the_eye"] else []),
        *_color_lines(facts["color"]),
        *_depth_lines(facts["depth"]),
        *_behind_lines(facts["behind"]),
        *(("note", note) for note in _notes(facts)),
    ]


def _notes(facts: Facts) -> list[str]:
    """Return the notes without those on the depth convention, which has lines of its own."""
    reason, question = (facts["depth"].get(name, "") for name in ("why", "question"))
    notes = (
        note.removesuffix(reason).rstrip() * bool(question)
        if reason and note.endswith(reason)
        else note
        for note in facts["notes"]
    )
    return [note for note in notes if note]


def _window_text(corners: list[int]) -> str:
    """Format the first and the last pixel of a window, as other EXR tools do."""
    x0, y0, x1, y1 = corners
    return f"({x0}, {y0}) to ({x1 - 1}, {y1 - 1})"


def _part_lines(parts: list[Facts]) -> list[Line]:
    """Return one line for each part and one for each type of channel in it."""
    lines = []
    for count, part in enumerate(parts, start=1):
        name = f" {part['name']!r}" if part["name"] else ""
        lines.append((f"part {count}", f"{part['type']}, {part['compression']}{name}"))
        by_type: dict[str, list[str]] = {}
        for channel, pixel_type in part["channels"].items():
            by_type.setdefault(pixel_type, []).append(channel)
        lines += [(f"  {pixel_type}", ", ".join(names)) for pixel_type, names in by_type.items()]
    return lines


def _camera_lines(camera: Facts) -> list[Line]:
    """Return the lens values of the header, each with the attribute it comes from."""
    lines = []
    for label, name, unit in _CAMERA_LINES:
        if camera[name] is not None:
            value = f"{_number_text(camera[name])} {unit}".rstrip()
            lines.append((label, f"{value} ({_value_source_text(camera['sources'][name])})"))
        elif name in camera["refused"]:
            reason = "ignored: no real lens has this value"
            lines.append((label, f"none (header: {camera['refused'][name]}: {reason})"))
    if camera["model"] is None:
        lines = lines or [("camera", "nothing in the header")]
        lines.append(("lens model", f"{LensModel.PHOTOGRAPHIC} (the header names no CG renderer)"))
    return lines


def _value_source_text(source: str) -> str:
    return source if source.startswith("header, ") else f"header: {source}"


def _primaries_lines(primaries: Facts | None) -> list[Line]:
    """Return the primaries of the colors, and the attribute that states them."""
    if primaries is None:
        return [("primaries", "linear Rec.709 (the header names no other)")]
    if primaries["space"] is None:
        conversion = "unknown to heatlens; taken as the current input space"
        if primaries["by_matrix"]:
            conversion = "converted to linear Rec.709 by a matrix for display"
        return [
            ("primaries", f"{primaries['value']} (header: {primaries['attribute']}), {conversion}")
        ]
    return [("primaries", f"{primaries['space']} (header: {primaries['attribute']})")]


def _color_lines(color: Facts) -> list[Line]:
    """Return layer and range of the color, or why there is none."""
    lines = []
    if "layer" in color:
        alpha = "with alpha" if color["has_alpha"] else "no alpha"
        view = f" of the view {color['view']}" if color["view"] else ""
        lines.append(("colour", f"{color['layer'] or 'RGB'}{view}, {alpha}"))
        range_text = "no finite value"
        if color["min"] is not None:
            range_text = f"{_number_text(color['min'])} to {_number_text(color['max'])}"
        invalid_counts = f"{color['nan_count']} NaN, {color['infinite_count']} infinite"
        lines.append(("colour range", f"{range_text}, {invalid_counts}"))
    if "problem" in color:
        lines.append(("colour", f"none: {color['problem']}"))
    return lines


def _depth_lines(depth: Facts) -> list[Line]:
    """Return channel, convention with its reason and range of the depth, or why there is none."""
    if "problem" in depth:
        return [("depth", f"none: {depth['problem']}")]
    lines = [
        ("depth", f"{depth['channel']}, {depth['convention']}, {depth['kind']}"),
        ("  why", depth["why"]),
    ]
    if "min_px" in depth:
        range_text = (
            f"{_number_text(depth['min_px'])} to {_number_text(depth['max_px'])} px, signed "
            "diameter"
        )
        return [*lines, ("  range", range_text)]
    range_text = f"{_number_text(depth['near_m'])} to {_number_text(depth['far_m'])} m"
    if depth["near_m"] == "infinity":
        range_text = "none: every pixel is infinitely far"
    counts = f"{depth['infinite_count']} px infinite, {depth['repaired_count']} px repaired"
    return [*lines, ("  range", range_text), ("  counts", counts)]


def _behind_lines(behind: list[Facts]) -> list[Line]:
    """Return what each picture behind adds, or why it cannot be added."""
    return [
        (
            "behind",
            f"{picture['name']} {picture['words']}"
            + (f": {picture['problem']}" * bool(picture["problem"])),
        )
        for picture in behind
    ]


def _number_text(value: float | str) -> str:
    """Format a number with five digits; infinity is already a word."""
    return value if isinstance(value, str) else f"{value:.5g}"
