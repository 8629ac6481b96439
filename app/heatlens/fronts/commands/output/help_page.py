"""What `heatlens COMMAND --help` prints: one screen, with the names of what it leaves out.

`--help-all` prints every option of the command, and `--help GROUP` the options of one group.
"""

import argparse
import copy
import re
from collections.abc import Iterator, Sequence
from typing import Any

WHOLE = "all"  # the name of all groups together, for `--help-all`
_MOST_LINES = 60  # a longer help is shortened
# The options that most users of a command need; a new one is shown only if it stands here.
_COMMON_OPTIONS = frozenset(
    {
        *("--output", "--frames", "--overwrite", "--truth", "--address", "--size", "--plate"),
        *("--focal-length", "--sensor-width", "--f-stop", "--focus-distance", "--focus-at"),
        *("--quality", "--bokeh", "--exposure", "--camera"),
    }
)


class HelpAction(argparse.Action):
    """Prints the help of a command and ends; its values name groups of options."""

    def __call__(self, parser: argparse.ArgumentParser, *words: Any) -> None:
        """Print the help; `words` are the namespace, the names of groups and the option."""
        print(page_of(parser, *(words[1] or self.const or ())), end="")
        parser.exit()


def add_help_options(parser: argparse.ArgumentParser) -> None:
    """Add `--help [GROUP]` and `--help-all`."""
    parser.add_argument(
        "-h",
        "--help",
        action=HelpAction,
        nargs="*",
        metavar="GROUP",
        help="print the options that most users need, or those of a group",
    )
    parser.add_argument(
        "--help-all", action=HelpAction, nargs=0, const=(WHOLE,), help="print all options"
    )


def page_of(parser: argparse.ArgumentParser, *names: str) -> str:
    """Return the help of a command: what most users need, all options, or those of some groups.

    Exits with code 2 for a name that is none of its groups.
    """
    whole = parser.format_help()
    if names == (WHOLE,) or (not names and len(whole.splitlines()) <= _MOST_LINES):
        return whole
    if not names:
        return _short_page(parser)
    formatter = parser._get_formatter()
    for name in names:
        for group in _groups_called(name, parser):
            _add_section(formatter, group.title, group.description, group._group_actions)
    return formatter.format_help()


def _groups_called(name: str, parser: argparse.ArgumentParser) -> Sequence[argparse._ArgumentGroup]:
    """Return the groups of options with this word in their title; exit if there are none."""
    groups = [group for group in _option_groups(parser) if name.lower() in _words_of(group)]
    if not groups:
        names = ", ".join(_name_of(group) for group in _option_groups(parser))
        parser.error(f"--help: no group of options is called {name!r}; there are {names}")
    return groups


def _short_page(parser: argparse.ArgumentParser) -> str:
    """Return the usage, the common options, the names of the groups, and the examples."""
    formatter = parser._get_formatter()
    required_actions = [it for it in parser._actions if it.required or not it.option_strings]
    formatter.add_usage(parser.usage, required_actions, [])
    formatter.add_text(parser.description)
    _add_section(formatter, "arguments", None, [it for it in required_actions if _is_word(it)])
    common = [it for it in parser._actions if _COMMON_OPTIONS & set(it.option_strings)]
    _add_section(formatter, "options that most users need", None, list(map(_in_short, common)))
    formatter.start_section(f"more options: `{parser.prog} --help GROUP`, or --help-all")
    formatter.add_text("\n".join(_lines_of_groups(parser)))
    formatter.end_section()
    formatter.add_text(_first_examples(parser.epilog or ""))
    return formatter.format_help()


def _in_short(action: argparse.Action) -> argparse.Action:
    """Return an option with only the first clause of its help."""
    short = copy.copy(action)
    short.help = re.split(r"[;.] ", action.help or "", maxsplit=1)[0]
    return short


def _first_examples(epilog: str) -> str:
    """Return an epilog with its first three examples, each of which begins after two spaces."""
    starts = [match.start() for match in re.finditer(r"^  (?=\S)", epilog, re.MULTILINE)]
    return epilog[: starts[3]] if len(starts) > 3 else epilog


def _is_word(action: argparse.Action) -> bool:
    """Return True for an argument that is given without the name of an option."""
    return not action.option_strings


def _lines_of_groups(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield a line for each group of options: its name, and some of its options."""
    for group in _option_groups(parser):
        shown = [it for it in group._group_actions if it.help != argparse.SUPPRESS]
        options = [it.option_strings[-1] for it in shown if it.option_strings]
        text = " ".join(options[:3]) + (f" and {len(options) - 3} more" if options[3:] else "")
        yield f"{_name_of(group):<10} {text}"


def _option_groups(parser: argparse.ArgumentParser) -> list[argparse._ArgumentGroup]:
    """Return the groups of a command that have options."""
    return [
        group
        for group in parser._action_groups
        if any(it.option_strings for it in group._group_actions)
    ]


def _words_of(group: argparse._ArgumentGroup) -> list[str]:
    """Return the words of the title of a group, by each of which it can be asked for."""
    return (group.title or "").lower().split()


def _name_of(group: argparse._ArgumentGroup) -> str:
    """Return the word by which the help names a group: the last one of its title."""
    return _words_of(group)[-1]


def _add_section(
    formatter: argparse.HelpFormatter,
    title: str | None,
    description: str | None,
    actions: Sequence[argparse.Action],
) -> None:
    """Add a section to a help page; nothing if it has no arguments."""
    if actions:
        formatter.start_section(title)
        formatter.add_text(description)
        formatter.add_arguments(actions)
        formatter.end_section()
