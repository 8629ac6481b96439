"""Make the parser of a command from what its module declares."""

import argparse
from types import ModuleType


def add_command(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]", name: str, module: ModuleType
) -> None:
    """Add the command `name`.

    `module` has its one-line HELP, its DESCRIPTION, examples as EPILOG if there are any,
    `add_options(parser)` and `run(args)`.
    """
    parser = commands.add_parser(
        name,
        help=module.HELP,
        description=module.DESCRIPTION,
        epilog=getattr(module, "EPILOG", None),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    module.add_options(parser)
    parser.set_defaults(run=getattr(module, "run", None))
