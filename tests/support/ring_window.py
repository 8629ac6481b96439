"""A window without a screen whose lens follows a lens ring, by packets on this machine."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from heatlens.media.live.ring.address import Protocol, RingAddress
from heatlens.media.live.ring.receiver import LensReceiver
from heatlens.render.gpu.device import Device
from support.gui import Gui, gui_of
from support.patience import PATIENCE_S
from support.session_files import QUICK, room_file


@contextmanager
def window_following_ring(ctx: Device, protocol: Protocol, folder: Path) -> Iterator[Gui]:
    """Yield a window that listens on a free port, with a small plate."""
    plate = room_file(folder / "room.exr")
    with (
        LensReceiver(RingAddress(protocol, host="127.0.0.1", port=0)) as receiver,
        gui_of(ctx, plate, defocus=QUICK, lens_in=receiver) as gui,
    ):
        yield gui


def draw_until(gui: Gui, is_so: Callable[[], bool]) -> None:
    """Draw frames until `is_so()` is true; the time limit is generous."""
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end
        gui.frame()
        time.sleep(0.001)
