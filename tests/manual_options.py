"""Write app/manual/options.md, the table of all options of the command line.

    python tests/manual_options.py

It is made of the parsers alone. Run it when an option or its help has changed.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

from heatlens.fronts.commands.command_parser import build_parser

PAGE = Path(__file__).parents[1] / "app" / "manual" / "options.md"
_HEAD = """\
# Options of the command line

`heatlens COMMAND --help` shows what most users need, `--help GROUP` a group of these options, and
`--help-all` every option.
"""
_OF_EVERY_COMMAND = ("--help", "--help-all", "--quiet", "--verbose", "--run-networks")
_EVERY_COMMAND = "every command"
# The pages of the manual that are about the options of each group.
_PAGES = {
    "options": ("commands", "deliver"),
    "lens": ("lens", "opening", "tilt"),
    "blur": ("quality", "hidden"),
    "how to read the plate": ("depth", "plates", "photos", "hidden"),
    "3D scene": ("scenes",),
    "look": ("colour",),
    "frames": ("deliver",),
    "EXR": ("deliver",),
    "render farm": ("farm",),
    "reels and edits": ("edit",),
    "sending live": ("ring",),
    "over time": ("pull",),
    "focus that follows": ("pull",),
    "the shot and its plate": ("programs",),
    "limits": ("looks",),
    "difference": ("looks",),
    "what is compared": ("quality",),
    "blur of diffusion": ("quality",),
    "what is measured": ("quality",),
}


def commands_of(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """Yield the parsers of all commands that have no commands of their own."""
    nested = [it for it in parser._actions if isinstance(it, argparse._SubParsersAction)]
    if not nested:
        yield parser
    for command in nested[0].choices.values() if nested else ():
        yield from commands_of(command)


def option_page() -> str:
    """Return the page: a table for each group, with the commands that have an option."""
    rows: dict[str, dict[tuple[str, str], list[str]]] = {}  # commands by option and help, by group
    for command in commands_of(build_parser()):
        name = command.prog.removeprefix("heatlens ")
        for group in command._action_groups:
            for action in _shown_options(group):
                row = _option_text(action), _help_text(command, action)
                is_general = action.option_strings[-1] in _OF_EVERY_COMMAND
                users = rows.setdefault(group.title or "", {}).setdefault(row, [])
                users += [_EVERY_COMMAND] if is_general and not users else []
                users += [] if is_general else [name]
    return _HEAD + "".join(_table(title, options) for title, options in rows.items())


def _shown_options(group: argparse._ArgumentGroup) -> list[argparse.Action]:
    return [it for it in group._group_actions if it.option_strings and it.help != argparse.SUPPRESS]


def _option_text(action: argparse.Action) -> str:
    """Return the names of an option and its value: `-o`, `--output OUTPUT`."""
    formatter = argparse.HelpFormatter("")
    words = [*action.option_strings]
    if action.nargs != 0:
        value = formatter._format_args(action, formatter._get_default_metavar_for_optional(action))
        words[-1] += f" {value}"
    return _in_cell(", ".join(f"`{word}`" for word in words))


def _help_text(command: argparse.ArgumentParser, action: argparse.Action) -> str:
    return _in_cell(" ".join(command._get_formatter()._expand_help(action).split()))


def _in_cell(text: str) -> str:
    """Return a text for a cell of a table, whose bars are no borders."""
    return text.replace("|", "\\|")


def _table(title: str, options: dict[tuple[str, str], list[str]]) -> str:
    """Return a group as a section with a table."""
    lines = [f"| {name} | {text} | {', '.join(users)} |" for (name, text), users in options.items()]
    pages = " · ".join(f"[{_title_of(name)}]({name}.md)" for name in _PAGES[title])
    head = (
        f"\n## {title[:1].upper()}{title[1:]}\n\n{pages}\n\n| option | what it does | commands |\n"
    )
    return head + "| --- | --- | --- |\n" + "\n".join(lines) + "\n"


def _title_of(name: str) -> str:
    """Return the title of a page of the manual."""
    return (PAGE.parent / f"{name}.md").read_text("utf-8").splitlines()[0].removeprefix("# ")


def main() -> None:
    """Write the page."""
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(option_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
