"""What `heatlens info` prints of a reel or an edit."""

from heatlens.commands.sources.source_commands import Facts, Line
from heatlens.files.json_record import record_to_json
from heatlens.model.reel import Reel, ReelShot


def reel_info(reel: Reel) -> tuple[Facts, list[Line]]:
    """Return the facts of a reel for programs, and as lines for people."""
    facts = {
        "reel": reel.name,
        "frames_per_second": reel.frames_per_second,
        "start_timecode": reel.start_timecode,
        "shots": [record_to_json(shot) for shot in reel.shots],
        "missing": [shot.name for shot in reel.missing],
    }
    start = f", from {reel.start_timecode}" if reel.start_timecode else ""
    about = f"{len(reel.shots)} shots, {reel.frames_per_second:g} frames a second{start}"
    lines = [("reel", reel.name), ("cut", about)]
    for shot in reel.shots:
        lines += _lines(shot)
    return facts, lines


def _lines(shot: ReelShot) -> list[Line]:
    frames = "all frames"
    if shot.frames is not None:
        frames = f"{shot.frames} ({shot.frames.count})"
    about = f"{shot.source}, {frames}" if shot.source else f"no media, {frames}"
    grade = [] if shot.grade is None else [("  grade", str(shot.grade))]
    marks = [("  mark", mark) for mark in shot.marks]
    return [(shot.name, about), *marks, *grade, *(("  note", note) for note in shot.notes)]
