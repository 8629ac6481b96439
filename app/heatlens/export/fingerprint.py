"""By what a finished frame is known again: a digest of all that decides its pixels.

Not that a file is there says that it is done, but that this one was made of the same plate or
scene, lens and options. What it is made of is known by time and size of its file, looked at before
it is read: one that is written again meanwhile is rendered again. So are the files that a glTF
names, its buffers and pictures; of other scenes only the first file counts, and the program's own
is known by the program's version.
"""

from collections.abc import Iterable
from typing import Any

from heatlens import __version__
from heatlens.export.frame_source import Origin
from heatlens.export.job import ExportJob
from heatlens.files.json_record import plain
from heatlens.model.framing import Framing
from heatlens.model.lens import Lens
from heatlens.plate.picture_digest import digest, without_advice


def fingerprint_of(job: ExportJob, frame: int, lens: Lens, origin: Origin) -> str:
    """32 hexadecimal digits for one frame; where nothing that matters differs, the same."""
    return digest(
        {
            "version": __version__,
            "frame": frame,
            "plate": origin.stamp,
            **({"beside": origin.beside} if origin.beside else {}),
            "is_black": origin.is_black,
            "plate_options": plain(job.shot.plate_options),
            "lens": plain(without_advice(lens)),
            "framing": plain(job.shot.framing or Framing()),
            "defocus": None if job.pinhole else plain(job.shot.defocus),
            "output": _output_facts(job),
        }
    )


def fingerprint_of_movie(frames: Iterable[str], frames_per_second: float) -> str:
    """One for a movie whose frames have these."""
    return digest({"frames": list(frames), "frames_per_second": frames_per_second})


def _output_facts(job: ExportJob) -> dict[str, Any]:
    """The options that count for this kind of file."""
    if job.output.is_exr:
        return {"kind": ".exr", **plain(job.exr)}
    look = job.look
    return {
        "kind": job.output.suffix,
        "view": [look.transform.key, look.transform.input_space],
        "exposure_stops": look.exposure_stops,
        "gamma": look.gamma,
        "burn_in": look.unit if look.burn_in else None,
    }
