"""Movies with sound, edits and captures for the fuzzers."""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import opentimelineio

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.deliver.export.movie_sound import has_whole_sound
from heatlens.media.documents.reel_file import read_reel, write_reel
from heatlens.media.files.movie_read import movie_at
from heatlens.media.plate.picture.capture_folder import capture_info
from support.movies import CODECS, ramps, write_movie

_SMALL = {"count": 3, "width": 48, "height": 32}  # small files are damaged where it counts
_SOUND = np.arange(12_000, dtype=np.int16).reshape(-1, 2)
_CAPTURE = {"K": [40.0, 0, 0, 0, 40.0, 0, 24, 16, 1], "w": 48, "h": 32, "fps": 30, "poses": [[0.5]]}


def movies(folder: Path) -> list[Path]:
    """Write a movie in each codec, with sound if the container allows it."""
    paths = []
    for number, (codec, (suffix, *_)) in enumerate(CODECS.items()):
        sound = _SOUND if suffix in (".mov", ".mkv") else None
        paths.append(write_movie(folder / f"{number}{suffix}", ramps(**_SMALL), codec, sound=sound))
    return paths


def frames_and_sound(path: Path) -> Iterable[np.ndarray]:
    """Read the frames out of order, then the sound."""
    movie = movie_at(path)
    for number in (movie.count - 1, 0):
        yield movie.frame(number).values
    if movie.has_sound:
        has_whole_sound(path)


def edits(folder: Path) -> list[Path]:
    """Write a cut with a gap, a retime, a dissolve and a marker in each format."""
    opentime, schema = opentimelineio.opentime, opentimelineio.schema
    rate = 24.0
    track = schema.Track("V1", kind="Video")
    for number, start in enumerate((86_400, 86_448)):
        span = opentime.TimeRange(
            opentime.RationalTime(start, rate), opentime.RationalTime(24, rate)
        )
        media = schema.ExternalReference(f"plates/s{number}.####.exr", span)
        clip = schema.Clip(f"s{number}", media, span)
        clip.markers.append(
            schema.Marker("A 2.4m", opentime.TimeRange(span.start_time, span.duration))
        )
        track.append(clip)
        gap = opentime.TimeRange(opentime.RationalTime(0, rate), opentime.RationalTime(3, rate))
        track.append(schema.Gap(source_range=gap))
    track[2].effects.append(schema.LinearTimeWarp(time_scalar=2.0))
    timeline = schema.Timeline("cut")
    timeline.tracks.append(track)
    paths = []
    for suffix, adapter in ((".otio", None), (".edl", "cmx_3600"), (".xml", "fcp_xml")):
        path = folder / f"cut{suffix}"
        opentimelineio.adapters.write_to_file(timeline, str(path), adapter)
        paths.append(path)
    shots = (ReelShot("a", str(folder / "a.####.exr"), FrameRange(1, 9)), ReelShot("b", "b.glb"))
    write_reel(folder / "cut.heatreel.json", Reel("cut", shots, 24.0, "01:00:00:00", ((1, 2),)))
    return [*paths, folder / "cut.heatreel.json"]


def frames_of_edit(path: Path) -> Iterable[np.ndarray]:
    """Read the shots of an edit."""
    reel = read_reel(path)
    spans = [shot.frames for shot in reel.shots if shot.frames is not None]
    return [np.array([reel.frames_per_second, *(span.first for span in spans)], float)]


def captures(folder: Path) -> list[Path]:
    """Write the description of a capture."""
    (folder / "rgb").mkdir()
    (folder / "metadata.json").write_text(json.dumps(_CAPTURE))
    return [folder / "metadata.json"]


def lens_of_capture(path: Path) -> Iterable[np.ndarray]:
    """Read the lens of a picture beside the description."""
    header = capture_info(path.parent / "rgb" / "0.jpg", (48, 32)).get("header", {})
    return [np.asarray(value, float) for value in header.values()]
