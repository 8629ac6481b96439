"""The output of `heatlens info` for a 3D scene."""

from heatlens.commands.sources.source_commands import Facts, Line

_NAMES_MOST = 8  # of objects, in a line


def scene_lines(facts: Facts) -> list[Line]:
    """Return the facts of `scene_facts` as text, each with a label."""
    return [
        ("scene", facts["path"]),
        ("frames", _frames(facts)),
        *([("clips", ", ".join(facts["clips"]))] if len(facts["clips"]) > 1 else []),
        *_camera_lines(facts["cameras"]),
        ("lens model", facts["lens_model"]),
        ("objects", _objects(facts["objects"])),
        ("triangles", f"{facts['triangles']:,}"),
        ("lights", _lights(facts)),
        ("size", " x ".join(f"{side:.4g}" for side in facts["size_m"]) + " m, y up"),
        *(("note", note) for note in facts["notes"]),
    ]


def _frames(facts: Facts) -> str:
    frames = facts["frames"]
    if frames is None:
        return "nothing moves"
    return f"{frames['first']} to {frames['last']}, {facts['frames_per_second']:g} per second"


def _camera_lines(cameras: list[Facts]) -> list[Line]:
    """Return a line for each camera; the first is used unless another is named."""
    lines = [
        (
            "camera",
            f"{camera['name']}, focal length {camera['focal_length_mm']:.4g} mm, sensor width "
            f"{camera['sensor_width_mm']:.4g} mm{_how(camera)}",
        )
        for camera in cameras
    ]
    return lines or [("camera", "none: all of the scene is seen")]


def _how(camera: Facts) -> str:
    assumed = " (assumed: the file has only its angle of view)"
    moves = ", moves" if camera["moves"] else ""
    return (assumed if camera["sensor_width_assumed"] else "") + moves


def _objects(names: list[str]) -> str:
    shown = ", ".join(names[:_NAMES_MOST])
    more = f" and {len(names) - _NAMES_MOST} more" if len(names) > _NAMES_MOST else ""
    return f"{len(names)}: {shown}{more}"


def _lights(facts: Facts) -> str:
    lamps = {0: "", 1: "1 lamp"}.get(facts["lights"], f"{facts['lights']} lamps")
    sun = "the sun" if facts["sun"] else ""
    return " and ".join(part for part in (sun, lamps) if part) or "none but the sky"
