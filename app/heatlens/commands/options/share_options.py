"""Sharing on the command line, for `serve` and `view --share`: options, and the links to print."""

import argparse
import sys
from pathlib import Path

from heatlens.commands.output.say import tell
from heatlens.share.address import ShareOptions, parse_share_address
from heatlens.share.links import Role
from heatlens.share.sharing import Sharing, code_for_terminal


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


def share_options_of(args: argparse.Namespace, address: str) -> ShareOptions:
    """Return the options for sharing at `address`. Raises InputError for no address."""
    return ShareOptions(parse_share_address(address, args.certificate), args.new_links)


def tell_links(sharing: Sharing) -> None:
    """Print the link of each role."""
    tell(f"Turn the lens at   {sharing.link(Role.HAND)}")
    tell(f"Only look at it at {sharing.link(Role.LOOK)}")
    if sys.stdout.isatty():
        tell(code_for_terminal(sharing.link(Role.HAND)), keep="\n\x1b")
