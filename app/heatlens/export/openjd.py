"""Describe an export as a job for a render farm, in a template of Open Job Description 2023-09.

https://github.com/OpenJobDescription/openjd-specifications/wiki/2023-09-Template-Schemas
"""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from heatlens.base.errors import InputError
from heatlens.sequence.names import frames_text

# Limits of the schema: values of a task parameter, characters in one, characters of a job's name.
_TASKS_MOST, _TEXT_MOST, _NAME_MOST = 1024, 1024, 128


@dataclass(frozen=True)
class PathParameter:
    """A path that may differ between the machines of a farm."""

    name: str
    path: Path
    kind: Literal["FILE", "DIRECTORY"]
    flow: Literal["IN", "OUT"]

    def relative_to(self, folder: Path) -> str | None:
        """Return the path relative to `folder` if it is below; else None."""
        relative = os.path.relpath(self.path, folder)
        return None if relative.startswith(os.pardir) else Path(relative).as_posix()


def chunks_of(frames: Sequence[int], chunk: int) -> tuple[str, ...]:
    """Return `frames` in groups of `chunk`, in the form of `parse_frames`: 1001-1019x2.

    Raises InputError for empty groups, and for more or longer groups than a template allows.
    """
    if chunk < 1:
        raise InputError(f"--chunk must be 1 frame or more, got {chunk}.")
    groups = [frames[start : start + chunk] for start in range(0, len(frames), chunk)]
    if len(groups) > _TASKS_MOST:
        raise InputError(
            f"{len(frames)} frames in chunks of {chunk} are {len(groups)} tasks; a job has at most "
            f"{_TASKS_MOST}. Give a larger --chunk."
        )
    texts = tuple(frames_text(group) for group in groups)
    if max(map(len, texts)) > _TEXT_MOST:
        raise InputError("These frames are too irregular for one task. Give a smaller --chunk.")
    return texts


def job_template(
    name: str,
    paths: Sequence[PathParameter],
    words: Sequence[str],
    chunks: Sequence[str],
    folder: Path,
) -> str:
    """Return the template as YAML for `folder`, which runs `heatlens WORDS` for each chunk.

    In `words`, {{Param.NAME}} stands for a path and {{Task.Param.Frames}} for the chunk.
    """
    template = {
        "specificationVersion": "jobtemplate-2023-09",
        "name": f"heatlens {name}"[:_NAME_MOST],
        "parameterDefinitions": [_definition(path, folder) for path in paths],
        "steps": [
            {
                "name": "Export",
                "parameterSpace": {
                    "taskParameterDefinitions": [
                        {"name": "Frames", "type": "STRING", "range": list(chunks)}
                    ]
                },
                "script": {"actions": {"onRun": {"command": "heatlens", "args": list(words)}}},
            }
        ],
    }
    return "\n".join(_yaml(template)) + "\n"


def _definition(path: PathParameter, folder: Path) -> dict[str, str]:
    relative = path.relative_to(folder)
    default = {} if relative is None else {"default": relative}
    flow = {"objectType": path.kind, "dataFlow": path.flow}
    return {"name": path.name, "type": "PATH", **flow, **default}


def _yaml(value: object) -> list[str]:
    """Return lines of YAML in block style; texts are quoted as in JSON, a subset of YAML."""
    if isinstance(value, dict):
        return [line for name, entry in value.items() for line in _yaml_entry(name, entry)]
    if isinstance(value, list):
        return [line for item in value for line in _indented(_yaml(item), "- ")]
    return [json.dumps(value, ensure_ascii=False)]


def _yaml_entry(name: str, value: object) -> list[str]:
    if isinstance(value, dict | list):
        return [f"{name}:", *_indented(_yaml(value), "  ")]
    return [f"{name}: {_yaml(value)[0]}"]


def _indented(lines: list[str], first: str) -> list[str]:
    return [f"{first}{lines[0]}", *(f"  {line}" for line in lines[1:])]
