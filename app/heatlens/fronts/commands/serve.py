"""`heatlens serve`: a session for browsers alone, without a window."""

import argparse
from threading import Event

from heatlens.core.base.paths import preferences_dir, rendered_frames_dir
from heatlens.core.base.stopping import StopSignals
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.output.say import print_messages
from heatlens.fronts.commands.view import (
    add_share_options,
    add_view_options,
    given_share_options,
    open_session,
    print_links,
)
from heatlens.render.display.front_end import FrontEnd
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import headless_renderer
from heatlens.render.gpu.context import is_software
from heatlens.studio.board.session import Session
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from heatlens.studio.share.headless import HeadlessLoop
from heatlens.studio.share.sharing import Sharing

DESCRIPTION = """\
Serves the director's page: any browser, on a tablet, a phone or a laptop, turns the lens of the
picture that this machine renders. It needs no display, so it also runs over SSH or in a container.
Open the printed link, or scan the code with the tablet's camera. The link is a key: whoever has it
can turn the lens, but can open or write no file. The second link may only look, for clients.
"""
EPILOG = """\
examples:
  heatlens serve                             # the demo, for a browser on this machine
  heatlens serve shot.heatlens.json --address 192.168.1.20   # for the tablets of this network
  heatlens serve plate.exr --address 192.168.1.20 --certificate stage.pem   # with TLS
  ssh -L 8870:localhost:8870 workstation heatlens serve plate.exr   # through SSH

Ctrl-C ends it. Changes are kept as unsaved changes of the shot, which `heatlens view` offers.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options."""
    parser.add_argument(
        "plate",
        nargs="?",
        help="what to open, as for `heatlens view`: a plate, a sequence, a scene or a shot "
        "(default: the demo)",
    )
    add_device_option(parser)
    parser.add_argument(
        "--address",
        default="",
        metavar="HOST[:PORT]",
        help="the address of this machine that tablets reach, such as 192.168.1.20 (default: only "
        "this machine, port 8870)",
    )
    add_share_options(parser)
    add_view_options(parser)


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl-C."""
    use_device(args)
    if not args.plate and args.listen is None:
        args.demo = True
    wake_event = Event()
    return open_session(args, lambda start: _serve(args, start, wake_event), wake_event.set)


def _serve(args: argparse.Namespace, start: Start, wake_event: Event) -> None:
    """Share a session and run it until Ctrl-C; print its links first."""
    sharing = Sharing(given_share_options(args, args.address), wake_event.set)
    sharing.begin(print_messages)
    try:
        print_links(sharing)
        renderer = headless_renderer()
        screen = ScreenPictures(renderer.ctx)
        front_end = FrontEnd(wake_event.set, screen, has_window=True)
        preferences = Preferences.load(preferences_dir())
        session = Session(
            *(renderer, start, front_end, preferences, rendered_frames_dir()),
            is_software(renderer.ctx),
        )
        session.begin()
        with StopSignals(wake_event.set) as stops:
            loop = HeadlessLoop(session, screen, sharing.shared, wake_event)
            loop.run(lambda: bool(stops.number))
        session.close()
        stops.raise_if_stopped()
    finally:
        sharing.end()
