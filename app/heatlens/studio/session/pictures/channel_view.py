"""Show a channel of the plate's file in place of the picture."""

from functools import partial
from pathlib import Path

import numpy as np

from heatlens.core.base.background import Background
from heatlens.core.base.faults import report_faults
from heatlens.core.base.messages import Worker
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Against, Compare
from heatlens.core.model.view.view_geometry import Pixel
from heatlens.media.plate.channel_picture import ChannelPicture, channel_choices, read_channel
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import new_texture, upload
from heatlens.studio.session.shared import Commands, Shared

_Key = tuple[Path, str]  # a file, and what is shown of it


class ChannelView(Commands, Worker):
    """Reads the chosen channel of each shown frame on a thread, and keeps it on the GPU."""

    def __init__(self, shared: Shared, view: PictureView) -> None:
        super().__init__(shared)
        self._view = view
        self._ctx = shared.source.picture.renderer.ctx
        self._reader: Background[tuple[_Key, ChannelPicture]] = Background(self._wake)
        self._requested: _Key | None = None
        self._shown: _Key | None = None
        self.picture: ChannelPicture | None = None
        self.texture: Texture | None = None

    @property
    def choices(self) -> tuple[str, ...]:
        """The layers and channels of the shown plate; none for a scene."""
        plate = self._source.plate
        return () if plate is None or self._source.has_camera else channel_choices(plate.aovs)

    @property
    def is_current(self) -> bool:
        """True if the channel on the GPU is the chosen one of the shown frame."""
        return self._shown is not None and self._shown == self._wanted

    @property
    def _wanted(self) -> _Key | None:
        """The file and the channel to show; None if none is chosen."""
        plate, state = self._source.plate, self._view.state
        is_chosen = state.against is Against.CHANNEL and state.compare is not Compare.OFF
        return (plate.path, state.channel) if plate is not None and is_chosen else None

    def words_at(self, file_px: Pixel) -> str:
        """Return the shown channel's values at a pixel of the file; "" if none is shown."""
        plate = self._source.plate
        if not self.is_current or self.picture is None or plate is None:
            return ""
        column, row = file_px[0] - plate.data_window.x0, file_px[1] - plate.data_window.y0
        return f"{self.picture.words_at(row, column)}   "

    def poll(self) -> None:
        """Read the channel that is wanted, and use it once it is read. Raises InputError."""
        wanted = self._wanted
        if wanted != self._requested:
            self._requested = wanted
            if wanted is not None:
                self._reader.start(partial(_read, wanted))
        result = self._reader.poll()
        if result is None:
            return
        self._shown, self.picture = result
        if self.texture is not None:
            self.texture.release()
        height, width = self.picture.pixels.shape[:2]
        self.texture = new_texture(self._ctx, (width, height), 4, label="channel")
        upload(self.texture, np.ascontiguousarray(self.picture.pixels))


@report_faults("The channel could not be read")
def _read(key: _Key) -> tuple[_Key, ChannelPicture]:
    """Return a channel with what it is of. Raise HeatlensError if it cannot be read."""
    return key, read_channel(*key)
