"""Load the reference: a picture file that the rendered picture is compared with."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import moderngl
import numpy as np

from heatlens.base.background import Background
from heatlens.base.faults import faults_reported
from heatlens.gpu.context import check_plate_fits
from heatlens.gpu.textures import new_texture, upload
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.file_parts import color_file_parts
from heatlens.plate.header.channel_choice import choose_color
from heatlens.plate.plate import FloatImage
from heatlens.plate.read import read_color
from heatlens.session.loop.worker import Worker
from heatlens.session.shared import Commands, Shared


@dataclass(frozen=True, eq=False)
class Reference:
    """The colours of a picture file, as side B of a comparison."""

    path: Path
    texture: moderngl.Texture


@faults_reported("The reference could not be read")
def read_reference(path: Path) -> tuple[Path, FloatImage]:
    """Return the path and the colours, (H, W, 4), of a picture file. Raise HeatlensError."""
    parts = color_file_parts(path, PlateOptions())
    choice = choose_color(path, [header for header, _ in parts], None)
    return path, read_color(path, parts, choice)[0]


class ReferenceLoader(Commands, Worker):
    """Reads a reference on a thread and keeps the latest one on the GPU."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.current: Reference | None = None
        self._ctx = shared.source.picture.renderer.ctx
        self._reader: Background[tuple[Path, FloatImage]] = Background(self._wake)

    def open(self, path: Path) -> None:
        """Begin to read a reference."""
        self._reader.start(partial(read_reference, path))

    def poll(self) -> None:
        """Put a new reference on the GPU and say so.

        Raise HeatlensError if it cannot be read; the previous one stays.
        """
        found = self._reader.poll()
        if found is None:
            return
        path, pixels = found
        size = (pixels.shape[1], pixels.shape[0])
        check_plate_fits(self._ctx, *size)
        texture = new_texture(self._ctx, size, 4, label="reference")
        upload(texture, np.ascontiguousarray(pixels))
        if self.current is not None:
            self.current.texture.release()
        self.current = Reference(path, texture)
        self._say(f"B is {path.name}.")
