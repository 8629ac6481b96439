"""Notes on a plate and the lens in front of it, for commands and Python callers."""

from collections.abc import Sequence

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Explained
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.focus.plausibility import Doubt, find_doubts, focus_unit_doubts
from heatlens.core.model.lens.breathing import breathing_note
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.overscan_need import overscan_ratio
from heatlens.media.plate.plate import Plate, depth_span


def depth_note(plate: Plate) -> Explained:
    """Return how the depth was read, and why: "depth: Z, metres, 0.44 to 4.64"."""
    depth = plate.depth
    is_distance = depth.convention is DepthConvention.DISTANCE
    words = "metres" if is_distance else depth.convention.facts.label
    along = " along the ray" if depth.kind is DepthKind.RADIAL else ""
    is_even = depth.near_m == depth.far_m
    last = "" if is_even else f" to {depth.far_m:.3g}"
    ends = f", {depth.near_m:.3g}{last}" if plate.has_distances else ""
    unit = " m" if ends and not is_distance else ""
    sky = " and infinity" if ends and depth.infinite_count else ""
    return Explained(f"depth: {depth.channel}, {words}{along}{ends}{unit}{sky}", depth.why)


def lens_notes(plate: Plate, lens: Lens, scene_unit_m: float, is_strict: bool) -> tuple[str, ...]:
    """Return the effect of breathing, and doubts about this lens for the depths of the plate.

    `scene_unit_m` is the length in meters of the unit with which the depth was read. Raises
    InputError for the first doubt if `is_strict`.
    """
    return (*breathing_notes(lens, plate), *_lens_doubts(plate, lens, scene_unit_m, is_strict))


def shot_notes(shot: Shot, plate: Plate, without_unit_m: Sequence[float] = ()) -> tuple[str, ...]:
    """Return `lens_notes` for a shot; its lens is in doubt only if it is in doubt at every key.

    Focus distances `without_unit_m` had no unit and are assumed to be meters; they are in doubt if
    another unit fits the depths.

    Raises InputError for the first doubt if the plate options of the shot are strict.
    """
    options = shot.plate_options
    lenses = [shot.lens_at(frame) for frame in shot.key_frames] or [shot.lens]
    span = depth_span(plate, options.scene_unit_m)
    if unit_doubts := focus_unit_doubts(without_unit_m, span):
        return (
            *breathing_notes(shot.lens, plate),
            *_doubt_sentences(plate, unit_doubts, options.strict),
        )
    # A focus pull may begin in front of all surfaces, so every key must be in doubt.
    if not all(find_doubts(lens, span) for lens in lenses):
        return breathing_notes(shot.lens, plate)
    lens_doubts = _lens_doubts(plate, lenses[0], options.scene_unit_m, options.strict)
    return (*breathing_notes(shot.lens, plate), *lens_doubts)


def breathing_notes(lens: Lens, plate: Plate | None) -> tuple[str, ...]:
    """Return the effect of breathing on the picture of a plate; None stands for a scene."""
    note = breathing_note(lens, None if plate is None else overscan_ratio(plate))
    return (note,) if note else ()


def _lens_doubts(plate: Plate, lens: Lens, scene_unit_m: float, is_strict: bool) -> tuple[str, ...]:
    """Return sentences on doubts about a lens for the depths of a plate that has distances.

    Raises InputError for the first one if `is_strict`.
    """
    if not plate.has_distances:
        return ()
    return _doubt_sentences(plate, find_doubts(lens, depth_span(plate, scene_unit_m)), is_strict)


def _doubt_sentences(
    plate: Plate, found_doubts: Sequence[Doubt], is_strict: bool
) -> tuple[str, ...]:
    """Return the sentences of doubts. Raises InputError for the first one if `is_strict`."""
    if found_doubts and is_strict:
        raise InputError(f"{plate.path}: {found_doubts[0].sentence}")
    return tuple(doubt.sentence for doubt in found_doubts)
