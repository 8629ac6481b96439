"""Import packages that come with an extra of heatlens on first use."""

import importlib
from types import ModuleType

from heatlens.base.errors import InputError


def import_extra(module: str, purpose: str, extra: str) -> ModuleType:
    """Import a package of an extra, such as "flip_evaluator" of the extra "compare".

    `purpose` begins the sentence of the InputError for a package that cannot be imported.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{purpose} needs the package {module.partition('.')[0]}, which cannot be imported "
            f"({error}). Install it with: pip install 'heatlens[{extra}]'"
        ) from error
