"""`heatlens view`: the window. `heatlens plate.exr` means the same.

The options for sharing, and the printing of links, are used by `heatlens serve` too.
"""

import argparse
import os
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError, MissingPackageError, NoWindowError
from heatlens.core.base.extras import extra
from heatlens.fronts.commands.options.device_option import add_device_option, use_device_of_window
from heatlens.fronts.commands.options.field_options import add_blur_options, settings_of
from heatlens.fronts.commands.options.given_options import (
    changed_options,
    refuse_options,
    refuse_unused_options,
)
from heatlens.fronts.commands.options.kit_options import kit_of
from heatlens.fronts.commands.options.lens_options import (
    add_lens_options,
    add_plate_options,
    given_lens_fields,
    plate_options,
)
from heatlens.fronts.commands.options.scene_options import (
    add_placing_options,
    add_timing_options,
    given_placing,
    given_timing,
)
from heatlens.fronts.commands.options.shot_camera import add_camera_option, read_checked_camera
from heatlens.fronts.commands.output.pipes import DASH, stdin_as_file
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.media.documents.reel_file import is_reel
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.live.ring.address import opentrackio_address, parse_ring_address
from heatlens.media.live.ring.receiver import open_ring
from heatlens.media.live.ring.sender import LensSender
from heatlens.media.live.ring.sources import RingInput
from heatlens.media.live.stream.address import DEFAULT_PORT, parse_address
from heatlens.media.scene.scene_read import DEMO, is_demo
from heatlens.render.source.named import source_named
from heatlens.studio.board.window_handover import hand_over
from heatlens.studio.share.address import Role, ShareOptions, parse_share_address
from heatlens.studio.share.sharing import Sharing, qr_code_text

if TYPE_CHECKING:
    from heatlens.studio.settings.start import Start


DESCRIPTION = """\
Opens the window: click in the picture to focus, drag the aperture, compare, save. Without a plate
it shows a start screen with the demo, the still life and recent files. Lens values that are not
given here are taken from the plate's header, and can all be changed in the window. `F1` there shows
the keys. The window remembers recent files, the plate options of each folder, colours and panels in
the settings folder of the system, or in HEATLENS_CONFIG_DIR; options given here take precedence.
Rendered frames are kept in the cache folder of the system, or in HEATLENS_CACHE_DIR.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "plate",
        nargs="?",
        help="EXR with colour and depth, a sequence as shot.####.exr, a folder of one, "
        "a 3D scene (.glb, .gltf, .obj, .ply, .stl, .usd), "
        "a shot that was saved as name.heatlens.json, or - for a plate on standard input; "
        "default: a start screen with examples and recent files",
    )
    parser.add_argument(
        "--new-window",
        action="store_true",
        help="open another window; otherwise, if one is running and no options are given, that "
        "one opens the file",
    )
    parser.add_argument(
        "--share",
        nargs="?",
        const="",
        metavar="HOST[:PORT]",
        help="let tablets and browsers turn the lens too, on this address of this machine "
        "(default: for this machine alone, port 8870); see `heatlens serve --help`",
    )
    add_share_options(parser)
    add_device_option(parser)
    add_view_options(parser)


def add_view_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that set what is opened and how, also for `heatlens serve`."""
    parser.add_argument(
        "--demo", action="store_true", help="open the scene that comes with heatlens"
    )
    parser.add_argument(
        "--listen",
        nargs="?",
        const=str(DEFAULT_PORT),
        metavar="[HOST:]PORT",
        help="show the picture of a running renderer, sent in the protocol of the viewer tev "
        f"(default: port {DEFAULT_PORT} of this machine)",
    )
    parser.add_argument(
        "--lens-in",
        metavar="PROTOCOL[://HOST:PORT]",
        help="follow the lens of a camera (opentrackio, or opentrackio://239.135.1.1 for source 1 "
        "of a network) or a controller: osc://:9000, midi:NAME for a port of this machine, pad for "
        "a game pad or a jog wheel",
    )
    parser.add_argument(
        "--lens-out",
        metavar="opentrackio[://HOST:PORT]",
        help="send the lens at the playhead to an engine, a follow-focus or another heatlens, as "
        "a camera does: opentrackio for this machine",
    )
    parser.add_argument(
        "--ocio", metavar="CONFIG", help="OpenColorIO config (default: $OCIO, else a built-in one)"
    )
    add_camera_option(parser, "options")
    add_lens_options(parser, can_pick=False)
    add_blur_options(parser)
    add_plate_options(parser)
    group = parser.add_argument_group("3D scene")
    add_timing_options(group)
    add_placing_options(group)


def run(args: argparse.Namespace) -> int:
    """Open the window and return when it is closed.

    Without arguments and without a display, example pictures are rendered instead.
    """
    use_device_of_window(args)
    if args.plate == DASH:
        with stdin_as_file(Path(DASH)) as plate:  # read to its end before the window opens
            args.plate = str(plate)
            return _open(args)
    if _open_in_running_window(args):
        return 0
    if args.plate is not None or args.demo or args.listen is not None:
        return _open(args)
    try:
        return _open(args)
    except NoWindowError as error:
        from heatlens.fronts.commands.output.first_pictures import make_first_pictures

        return make_first_pictures(error)


def _open_in_running_window(args: argparse.Namespace) -> bool:
    """Have a running window open the files; False if there is none, or if options are given.

    Raises InputError for files that cannot be opened, as a new window would. Prints messages.
    """
    changed = changed_options(args, add_view_options, add_device_option)
    if not args.plate or args.new_window or args.share is not None or changed:
        return False
    _check_exists(args.plate)
    name = args.plate if is_demo(args.plate) else os.path.abspath(os.path.expanduser(args.plate))
    if not hand_over([name], lambda: print_messages("Waiting for the running window ...")):
        return False
    print_messages(f"{args.plate} was opened in the running window; --new-window opens another.")
    return True


def _check_exists(plate: str) -> None:
    """Raise InputError if the named file does not exist, before a window opens."""
    if is_shot_file(plate):
        read_shot(plate)
    else:
        source_named(plate).require()


def _open(args: argparse.Namespace) -> int:
    """Open a new window, shared if --share is given; raise NoWindowError without its packages."""
    try:
        with extra("gui").require():
            from heatlens.studio.ui.open_window import wake_window
            from heatlens.studio.ui.window import run_window
    except MissingPackageError as error:
        raise NoWindowError(f"{error}. `heatlens render` works without a window.") from error
    if args.share is None:
        return open_session(args, run_window, wake_window)
    sharing = Sharing(given_share_options(args, args.share), wake_window)
    # before the window opens, so that a wrong address is reported at once
    sharing.begin(print_messages)
    print_links(sharing)
    try:
        return open_session(args, lambda start: run_window(start, sharing), wake_window)
    finally:
        sharing.end()


def open_session(
    args: argparse.Namespace, run_session: Callable[["Start"], None], wake: Callable[[], None]
) -> int:
    """Build the start of a session from the options, and pass it to `run_session`.

    `run_session` returns when the user ends the session; threads call `wake` to make its loop turn.
    """
    from heatlens.studio.settings.start import Start

    if args.listen is not None:
        return _open_stream(args, run_session, wake)
    if args.demo and args.plate:
        raise InputError(f"--demo opens a scene of its own: leave {args.plate} out.")
    if args.plate == "":
        raise InputError("The name of the plate is empty: leave it out to choose in the window.")
    plate = DEMO if args.demo else args.plate or ""  # "": chosen in the window
    if plate:
        _check_exists(plate)
    if is_shot_file(plate):
        refuse_options(
            args, ("clip", "first_frame", "fps"), f"{plate} says how its scene is played"
        )
    elif plate and not is_reel(plate):
        refuse_unused_options(args, plate)
    lens = given_lens_fields(args)
    camera = read_checked_camera(args, lens)
    start = Start(plate, plate_options(args), lens, settings_of(args), ocio=args.ocio)
    timing, placing = given_timing(args, plate), given_placing(args)
    with _open_lens_output(args) as lens_out, _open_lens_input(args) as lens_in:
        start = replace(start, camera=camera, timing=timing, placing=placing, kit=kit_of(args))
        run_session(replace(start, lens_in=lens_in, lens_out=lens_out))
    return 0


def _open_lens_input(args: argparse.Namespace) -> AbstractContextManager[RingInput | None]:
    """Listen for the lens of a camera; the port is opened before the window."""
    return nullcontext() if args.lens_in is None else open_ring(args.lens_in)


def _open_lens_output(args: argparse.Namespace) -> AbstractContextManager[LensSender | None]:
    """Open the receiver of the lens. Raises InputError for an invalid address."""
    if args.lens_out is None:
        return nullcontext()
    address = opentrackio_address(args.lens_out)
    if args.lens_in is not None and args.lens_in.startswith("opentrackio"):
        if parse_ring_address(args.lens_in) == address:
            raise InputError(f"--lens-in and --lens-out cannot share an address: {address}.")
    return LensSender(address)


def _open_stream(
    args: argparse.Namespace, run_session: Callable[["Start"], None], wake: Callable[[], None]
) -> int:
    """Run a session on the picture that a renderer sends; the port is opened before the window."""
    from heatlens.render.source.stream_source import StreamSource
    from heatlens.studio.settings.start import Start

    if args.plate or args.demo:
        raise InputError(
            f"--listen shows what a renderer sends: leave {args.plate or '--demo'} out."
        )
    lens, defocus = given_lens_fields(args), settings_of(args)
    camera = read_checked_camera(args, lens)
    stream = StreamSource(*parse_address(args.listen), wake)
    start = Start(stream.text, plate_options(args), lens, defocus, ocio=args.ocio, stream=stream)
    try:
        with _open_lens_output(args) as lens_out, _open_lens_input(args) as lens_in:
            start = replace(start, lens_in=lens_in, lens_out=lens_out)
            run_session(replace(start, camera=camera, kit=kit_of(args)))
    finally:
        stream.close()
    return 0


def add_share_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how a session is shared."""
    parser.add_argument(
        "--certificate",
        type=Path,
        metavar="FILE",
        help="share through TLS: a PEM file with the certificate and its private key",
    )
    parser.add_argument(
        "--new-links",
        action="store_true",
        help="make all earlier links invalid; otherwise they keep working",
    )


def given_share_options(args: argparse.Namespace, address: str) -> ShareOptions:
    """Return the options for sharing at `address`. Raises InputError for no address."""
    return ShareOptions(parse_share_address(address, args.certificate), args.new_links)


def print_links(sharing: Sharing) -> None:
    """Print the link of each role."""
    print_result(f"Turn the lens at   {sharing.link(Role.HAND)}")
    print_result(f"Only look at it at {sharing.link(Role.LOOK)}")
    if sys.stdout.isatty():
        print_result(qr_code_text(sharing.link(Role.HAND)), keep="\n\x1b")
