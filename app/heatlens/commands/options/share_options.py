"""The options of sharing, which `serve` and `view --share` have."""

import argparse
from pathlib import Path

from heatlens.share.address import ShareOptions, parse_share_address


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
