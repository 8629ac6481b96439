"""Which options somebody gave, as against those that are at their default."""

import argparse
from collections.abc import Callable
from typing import Any

Given = dict[str, Any]
AddOptions = Callable[[argparse.ArgumentParser], object]


def given(args: argparse.Namespace, *groups: AddOptions) -> Given:
    """Those options of `groups` that are not at their default: as they are typed, and the value."""
    plain = argparse.ArgumentParser()
    for add in groups:
        add(plain)
    defaults = vars(plain.parse_args([])).items()
    names = [name for name, default in defaults if getattr(args, name) != default]
    return {f"--{name.replace('_', '-')}": getattr(args, name) for name in names}
