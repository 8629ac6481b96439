"""Count the frames of a movie that is named on the command line."""

import argparse
from pathlib import Path

from heatlens.files.picture_formats import movie_named


def count_movie_frames(args: argparse.Namespace) -> None:
    """Count the frames of a movie that is named in `args` from --first-frame."""
    first = getattr(args, "first_frame", None)
    for name in ("plate", "shot"):
        text = getattr(args, name, None)
        movie = None if text is None else movie_named(Path(text))
        if text is not None and movie is not None and first is not None and first >= 0:
            setattr(args, name, type(text)(f"{movie[0]}@{first}"))
            args.first_frame = None
