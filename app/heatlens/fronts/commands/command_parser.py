"""The parser of the command line: values as people type them, and what a wrong word means.

For a misspelt word, the error suggests the nearest known one.
"""

import argparse
import difflib
import os
import re
import sys
from collections.abc import Collection, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from heatlens.fronts.commands.command_table import COMMANDS, module_of
from heatlens.version import __version__

_EPILOG = """\
examples:
  heatlens plate.exr                        # the window; alone: with a start screen
  heatlens serve shot.heatlens.json         # for a tablet, in its browser
  heatlens render plate.exr -o out.exr --f-stop 2 --focus-distance 2.24 \\
      --focal-length 50 --sensor-width 36
  heatlens render plate.exr -o out.png --focus-at 960,540 --f-stop 1.4
  heatlens export shot.heatlens.json -o out/name.####.exr
  heatlens camera shot.heatlens.json -o cam.usda
  heatlens info plate.exr
  heatlens compare out.exr truth.exr --min-psnr 30
  heatlens study plate.exr --truth truth.exr -o report
  heatlens bench --bokeh disc --quality preview
  heatlens doctor

`heatlens COMMAND --help` explains each command.
"""

_OPTIONS_LISTED = 16  # options in a usage line; a longer list becomes [options]
_ALIKE = 0.7  # of 1 for the same word; --device is 0.62 like --denoise, --f-stop 0.91 like --fstop
_CAMERA_SUFFIXES = (".usd", ".usda", ".usdc", ".json", ".csv")


class _Parser(argparse.ArgumentParser):
    """Reports a wrong option in two lines; argparse would print the whole usage before them."""

    def __init__(self, *args: Any, **options: Any) -> None:
        """Make a parser with the options that all commands have."""
        super().__init__(*args, **options)
        self.add_argument(
            "-q",
            "--quiet",
            action="store_true",
            default=argparse.SUPPRESS,
            help="print only results and errors",
        )
        self.add_argument(
            "--run-networks",
            action="store_true",
            default=argparse.SUPPRESS,
            help="run a depth network that a shot names, without asking",
        )
        # No option begins with a digit, so such a word is a value: a frame, a pixel, a number.
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")

    def format_help(self) -> str:
        """Return the help; a usage with many options is shortened, as it would fill the screen."""
        if self.usage is None and len(self._option_string_actions) > _OPTIONS_LISTED:
            formatter = self._get_formatter()
            needed = [it for it in self._actions if it.required or not it.option_strings]
            formatter.add_usage(None, needed, [], "")
            words = formatter.format_help().strip().removeprefix(self.prog)
            self.usage = f"%(prog)s [options]{words.replace('%', '%%')}"
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        """Exit with code 2. Subcommands use this class too, because argparse inherits it."""
        self.exit(2, f"heatlens: {message}\n`{self.prog} --help` explains.\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse, and refuse unknown arguments here.

        Argparse would report them for the parent command.
        """
        words = self._with_values_joined(sys.argv[1:] if args is None else args)
        parsed, unknown = super().parse_known_args(words, namespace)
        if unknown and self.prog.endswith(" view") and parsed.plate in COMMANDS:
            right = " ".join((parsed.plate, *unknown))
            advice = f"options come after the command, as in: heatlens {right} --f-stop 2"
            self.exit(2, f"heatlens: {advice}\n`heatlens {parsed.plate} --help` explains.\n")
        if len(unknown) > 1 and all(map(os.path.isfile, unknown)):
            self.error(_unquoted(unknown))
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, self)}")
        return parsed, unknown

    def _with_values_joined(self, words: Sequence[str]) -> list[str]:
        """Join an option and its value where this begins with a minus and is no option itself."""
        # argparse takes -2-1, -70,50 and the names of files with a minus for options.
        joined: list[str] = []
        for word in words:
            before = joined[-1] if joined else ""
            is_value = len(word) > 1 and word[0] == "-" and not self._begins_option(word)
            if is_value and "--" not in joined and self._takes_one_value(before):
                joined[-1] = f"{before}={word}" if before.startswith("--") else before + word
            else:
                joined.append(word)
        return joined

    def _begins_option(self, word: str) -> bool:
        name = word.partition("=")[0]
        is_long = word.startswith("--")
        return name in self._option_string_actions or (is_long and bool(self._named(word)))

    def _takes_one_value(self, option: str) -> bool:
        return any(action.nargs is None for action in self._named(option))

    def _named(self, option: str) -> list[argparse.Action]:
        """Return the actions that an option or its beginning names."""
        known = self._option_string_actions
        if option in known:
            return [known[option]]
        is_begun = option.startswith("--") and len(option) > 2
        name = option.partition("=")[0]
        return [it for long, it in known.items() if is_begun and long.startswith(name)]

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Refuse a value that is not among the choices, and suggest the closest one."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            from heatlens.core.model.option import or_meant

            error.message += or_meant(str(value), map(str, action.choices or ()))
            raise

    def _get_option_tuples(self, option_string: str) -> list[Any]:
        """Return the options with this prefix, except those that mean something else elsewhere."""
        return [] if is_name_elsewhere(option_string) else super()._get_option_tuples(option_string)


def _unquoted(files: Sequence[str]) -> str:
    """Return the sentence for files that the shell put in the place of a pattern."""
    from heatlens.media.sequence.names import form_of  # loads fileseq, and only this needs it

    first = Path(files[0])
    pattern = str(first.with_name(form_of(first.name)[0].text))
    quoted = pattern if "#" in pattern else f"{first.with_name('plate')}.####{first.suffix}"
    return f"{len(files)} files too many. Put a pattern in quotes, with # for digits: '{quoted}'."


class _Completion(argparse.Action):
    """Prints the script and ends, as --help does."""

    def __call__(self, parser: argparse.ArgumentParser, *given: Any) -> None:
        """Print the completion; `given` are the namespace, the shell and the option."""
        import shtab

        print(shtab.complete(parser, shell=given[1]))
        raise SystemExit(0)


def build_parser(names: Collection[str] = COMMANDS) -> argparse.ArgumentParser:
    """Build the command line of the commands `names`; the default is all of them.

    The help names the others too, which cannot be run.
    """
    parser: argparse.ArgumentParser = _Parser(
        prog="heatlens",
        description="Puts a real lens in front of a pinhole render: depth of field by diffusion.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("-V", "--version", action="version", version=f"heatlens {__version__}")
    parser.add_argument(
        "--print-completion",
        action=_Completion,
        choices=("bash", "zsh", "tcsh"),
        help="print a completion script for this shell",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        if name in names:
            add_command(commands, name, command.help, module_of(name))
        elif not names:
            commands.add_parser(name, help=command.help)
    return parser


def add_command(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    help_line: str,
    module: ModuleType,
) -> None:
    """Add the command `name`.

    `module` has its DESCRIPTION, examples as EPILOG if there are any, `add_options(parser)` and
    `run(args)`.
    """
    parser = commands.add_parser(
        name,
        help=help_line,
        description=module.DESCRIPTION,
        epilog=getattr(module, "EPILOG", None),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    module.add_options(parser)
    parser.set_defaults(run=getattr(module, "run", None))


@cache
def _other_names() -> dict[str, str]:
    """Return our options by what people type who come from other programs."""
    from heatlens.core.model.option import OTHER_NAMES  # as slow as all that --version needs

    return {f"--{other}": f"--{own}" for other, own in OTHER_NAMES.items()}


def is_name_elsewhere(option: str) -> bool:
    """Return True for an option of other programs that is called something else here.

    "--aperture" is one, although it is also the beginning of --aperture-image.
    """
    name = option.partition("=")[0]
    return not _other_names().get(name, name).startswith(name)


def _elsewhere(option: str, value: str, prog: str) -> str:
    """Return the end of a sentence on the command that takes an option, or ""."""
    is_file = os.path.splitext(value)[1].lower() in _CAMERA_SUFFIXES
    if option == "--lens-from" or (option == "--camera" and is_file):
        return f". {option} gives the lens of a file to `heatlens shot new` and `heatlens view`."
    if prog.endswith(" camera") and option in _lens_flags():
        return f". The lens is that of the shot: `heatlens shot new` takes {option}."
    return ""


def _lens_flags() -> set[str]:
    # Slow, and seldom needed.
    from heatlens.fronts.commands.options.lens_options import add_lens_options

    parser = argparse.ArgumentParser(add_help=False)
    add_lens_options(parser)
    return set(parser._option_string_actions)


def meant(unknown: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """Return a sentence that suggests an option like the wrong one, or the command that has it."""
    known = [name for name in parser._option_string_actions if name.startswith("--")]
    for word, after in zip(unknown, (*unknown[1:], ""), strict=True):
        option, _, value = word.partition("=")
        if not option.startswith("--"):
            continue
        if elsewhere := _elsewhere(option, value or after, parser.prog):
            return elsewhere
        other = _other_names().get(option)
        near = [other] if other in known else _like(option, known)
        if near:
            return f". Did you mean {' or '.join(near)}?"
        if having := _commands_with(option):
            return f". It is an option of {' and '.join(f'`heatlens {name}`' for name in having)}."
    return ""


def _like(option: str, known: Sequence[str]) -> list[str]:
    """Return the two options that begin with the same word, or else the one most like it.

    The dashes are left out, because they would make every two short words alike.
    """
    longer = [name for name in known if name.startswith(f"{option}-")]
    if 0 < len(longer) <= 2:
        return sorted(longer, reverse=True)
    names = [name.lstrip("-") for name in known]
    return [f"--{it}" for it in difflib.get_close_matches(option.lstrip("-"), names, 1, _ALIKE)]


def _commands_with(option: str) -> list[str]:
    """Return the commands that have an option, which another one was given."""
    having = []
    for name in COMMANDS:
        own = argparse.ArgumentParser(add_help=False)
        module_of(name).add_options(own)
        having += [name] if option in own._option_string_actions else []
    return having
