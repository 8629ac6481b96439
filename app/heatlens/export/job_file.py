"""The options of an export as a JSON file, which the window hands to the process that exports."""

import json
from pathlib import Path
from typing import Any

from heatlens.export.options import ExportOptions
from heatlens.files.json_record import read_json, record_to_json
from heatlens.model.guides import Guides
from heatlens.model.look_options import LookOptions

_VERSION, _NEWEST = "heatlens_export_job", 1
_KINDS: dict[str, type] = {"options": ExportOptions, "look": LookOptions, "guides": Guides}


def job_text(*records: ExportOptions | LookOptions | Guides) -> str:
    """Return records of options as the text of a file that `read_job` can read."""
    entries = {name: r for name, kind in _KINDS.items() for r in records if isinstance(r, kind)}
    told = {name: record_to_json(record) for name, record in entries.items()}
    return json.dumps({_VERSION: _NEWEST, **told}, indent=2)


def read_job(path: Path) -> tuple[Any, ...]:
    """Return the records of a file. Raises InputError that names the damaged place in it."""
    top = read_json(path)
    top.check_version(_VERSION, _NEWEST, "export job")
    entries = top.members([_VERSION, *_KINDS])
    return tuple(entries[name].record(kind) for name, kind in _KINDS.items() if name in entries)
