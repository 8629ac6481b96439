"""Start heatlens twice, to see whether the driver keeps the shaders that it has compiled."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from heatlens.base.errors import GpuError
from heatlens.base.paths import data_dir
from heatlens.base.printable import one_line
from heatlens.doctor.finding import Finding

MOST_NEW = 0.05  # share of what the first start kept that a second one may add
_CACHES = ("MESA_SHADER_CACHE_DIR", "__GL_SHADER_DISK_CACHE_PATH")  # of Mesa and of NVIDIA


def second_start() -> Iterator[Finding]:
    """Report how much a second start compiles that the first one had compiled."""
    with tempfile.TemporaryDirectory(prefix="heatlens-") as folder:
        first, both = (_kept_bytes(Path(folder)) for _ in range(2))
    new = (both - first) / first if first else 1.0
    said = f"finds {100 * (1 - new):.0f} % of its shaders compiled by the first"
    if not first:
        said = "compiles every shader again: the driver keeps none, or keeps them elsewhere"
    details = {"kept_bytes": first, "share_new": new}
    yield Finding("second start", "ok" if new <= MOST_NEW else "note", said, details)


def _kept_bytes(folder: Path) -> int:
    """Render the still life in a process of its own; return the size of the driver's cache."""
    cache = folder / "cache"
    plate, picture = data_dir("assets") / "still_life.exr", folder / "picture.exr"
    command = [sys.executable, "-m", "heatlens", "render", str(plate), "-o", str(picture)]
    environment = os.environ | dict.fromkeys(_CACHES, str(cache))
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise GpuError(f"rendering in a process of its own fails: {one_line(done.stderr, 400)}")
    return sum(path.stat().st_size for path in cache.rglob("*") if path.is_file())
