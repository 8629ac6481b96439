"""`heatlens kits`: list the lens kits, and the limits of their lenses."""

import argparse
from pathlib import Path

from heatlens.core.model.lens.lens_kit import LensCharacter, LensKit
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.media.documents.lens_kits import KitShelf, kit_shelf, kit_text, read_kit
from heatlens.media.files.json_record import to_json

DESCRIPTION = """\
Lists the lens kits for --lens-kit and for the Lens panel of the window: the widest stop and the
close focus of each lens, and its look out of focus. Your own kits are JSON files in the folder that
is named at the end; to make one, copy a kit of heatlens (--json) and change it.
"""
EPILOG = """\
examples:
  heatlens kits
  heatlens kits vintage-primes
  heatlens kits vintage-primes --json > mine.json
  heatlens kits --check mine.json
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", help="only this kit (default: all)")
    parser.add_argument("--json", action="store_true", help="print one kit as in a kit file")
    parser.add_argument("--check", type=Path, metavar="FILE", help="check a kit file")


def run(args: argparse.Namespace) -> int:
    """Print the kits, and the problems of files that hold no valid kit."""
    if args.check is not None:
        print_result(_kit_text(read_kit(args.check)), keep="\n")
        return 0
    shelf = kit_shelf()
    kits = list(shelf.kits.values()) if args.name is None else [shelf.select_kit(args.name)[0]]
    if args.json:
        print_result("\n".join(kit_text(kit) for kit in kits), keep="\n")
        return 0
    print_result("\n\n".join(_kit_text(kit, shelf) for kit in kits), keep="\n")
    print_messages(*shelf.problems, f"your own kits belong in {shelf.folder}")
    return 0


def _kit_text(kit: LensKit, shelf: KitShelf | None = None) -> str:
    """Return a kit as text: its name, its lenses and its character, one a line."""
    own_note = " (your own)" if shelf is not None and kit.name in shelf.own else ""
    width = max(len(lens.name) for lens in kit.lenses)
    lenses = [f"  {lens.name:>{width}}  {lens.words}" for lens in kit.lenses]
    character_lines = _character_lines(kit.character)
    return "\n".join([f"{kit.name}{own_note}: {kit.words}", *lenses, *character_lines])


def _character_lines(character: LensCharacter) -> list[str]:
    """Return a line with the values of the character that are not at their default, if any."""
    default_values = LensCharacter().opening
    changed_values = {
        name: value for name, value in character.opening.items() if value != default_values[name]
    }
    value_texts = (
        f"{name.replace('_', ' ')} {to_json(value)}" for name, value in changed_values.items()
    )
    return [f"  {', '.join(value_texts)}"] if changed_values else []
