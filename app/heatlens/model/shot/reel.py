"""A reel: shots in the order in which they are cut, each a file of its own."""

import re
from dataclasses import dataclass, replace

from heatlens.base.errors import InputError
from heatlens.model.curves.frames import FRAMES_PER_SECOND, FrameRange, check_frames_per_second
from heatlens.model.shot.grade import Grade
from heatlens.model.shot.shot import Shot

SHOT_FIELD = "{shot}"  # stands for the name of the shot in the name of a file
_IN_FILE_NAMES = re.compile(r"[^\w.+-]+")


@dataclass(frozen=True)
class ReelShot:
    """A shot of a reel.

    name     what the reel calls it; part of the names of its files
    source   a shot file, or what the source of a shot can be: plates, a scene, a movie; "" if the
             media of the edit are missing
    frames   those of the cut; None for those from in to out, or all
    notes    sentences on what the edit says and a shot cannot hold, and on what is missing
    marks    focus marks that the edit holds, each as NAME=DISTANCE
    grade    of the edit; None if it has none
    """

    name: str
    source: str
    frames: FrameRange | None = None
    notes: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()
    grade: Grade | None = None

    def __post_init__(self) -> None:
        if not self.name or _IN_FILE_NAMES.search(self.name):
            raise InputError(f"A shot of a reel cannot be called {self.name!r}.")

    def part_of(self, shot: Shot) -> Shot:
        """Return what the cut shows of a shot: its frames, with its grade unless it has its own."""
        return replace(shot, in_out=self.frames or shot.in_out, grade=shot.grade or self.grade)


@dataclass(frozen=True)
class Reel:
    """Shots in order; no two have the same name.

    start_timecode  of the first frame of the cut; None if it is not known
    gaps            empty frames before shots, by the number of the shot from 0
    """

    name: str
    shots: tuple[ReelShot, ...]
    frames_per_second: float = FRAMES_PER_SECOND
    start_timecode: str | None = None
    gaps: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        check_frames_per_second(self.frames_per_second)
        if not self.shots:
            raise InputError(f"The reel {self.name} has no shot.")
        seen: set[str] = set()
        for shot in self.shots:
            if shot.name in seen:
                raise InputError(f"Two shots of the reel are called {shot.name}.")
            seen.add(shot.name)

    @property
    def missing(self) -> tuple[ReelShot, ...]:
        """The shots whose media are missing."""
        return tuple(shot for shot in self.shots if not shot.source)


def named_apart(shots: tuple[ReelShot, ...]) -> tuple[ReelShot, ...]:
    """Return the shots with a number after names that were used before: sh010, sh010_2."""
    taken: set[str] = set()
    made = []
    for shot in shots:
        name, number = shot.name, 1
        while name in taken:
            number += 1
            name = f"{shot.name}_{number}"
        taken.add(name)
        made.append(replace(shot, name=name))
    return tuple(made)


def shot_name(text: str) -> str:
    """Return a name for a shot that files can have: of letters, digits and . + - _ alone."""
    return _IN_FILE_NAMES.sub("_", text.strip()).strip("._") or "shot"
