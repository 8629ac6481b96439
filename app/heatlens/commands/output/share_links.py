"""Print the links of a shared session, and on a terminal a code to scan."""

import sys

from heatlens.commands.output.say import tell
from heatlens.share.links import Role
from heatlens.share.sharing import Sharing, code_for_terminal


def tell_links(sharing: Sharing) -> None:
    """Print the link of each role."""
    tell(f"Turn the lens at   {sharing.link(Role.HAND)}")
    tell(f"Only look at it at {sharing.link(Role.LOOK)}")
    if sys.stdout.isatty():
        tell(code_for_terminal(sharing.link(Role.HAND)), keep="\n\x1b")
