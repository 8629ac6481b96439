"""Keep the raw values of networks in files by the content of the picture and of the network."""

import hashlib
import os
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np

from heatlens.base.errors import InputError
from heatlens.base.folders import estimates_dir
from heatlens.files.atomic_file import FOR_THE_USER, replacing
from heatlens.plate.estimate.network import Network
from heatlens.plate.plate import FloatImage

_BYTES_MOST = 2 << 30
_SUFFIX = ".estimate.npy"


def estimate_kept(network: Network, seen: FloatImage) -> FloatImage:
    """Return the raw values of the network for what it sees, from a file if they were made before.

    Raises InputError if the network fails. If no file can be written, nothing is kept.
    """
    digest = hashlib.blake2b(seen.tobytes(), digest_size=16, key=network.key.encode())
    path = estimates_dir() / f"{digest.hexdigest()}{_SUFFIX}"
    with suppress(OSError, ValueError):  # it is missing or damaged
        kept: FloatImage = np.load(path, allow_pickle=False)
        os.utime(path)
        return kept
    values = network.estimate(seen)
    with suppress(OSError, InputError):  # a full or read-only disk
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        _make_room(path.parent)
        encoded = BytesIO()
        np.save(encoded, values)
        with replacing(path, FOR_THE_USER) as beside:
            beside.write_bytes(encoded.getvalue())
    return values


def _make_room(folder: Path) -> None:
    """Delete the files that were not used for longest, beyond the limit."""
    files = sorted(
        (file.stat().st_mtime_ns, file.stat().st_size, file) for file in folder.glob(f"*{_SUFFIX}")
    )
    total = sum(size for _, size, _ in files)
    for _, size, file in files:
        if total <= _BYTES_MOST:
            return
        file.unlink(missing_ok=True)
        total -= size
