"""Describe an export in a template of Open Job Description 2023-09, alone or in a job bundle.

https://github.com/OpenJobDescription/openjd-specifications/wiki/2023-09-Template-Schemas
https://docs.aws.amazon.com/deadline-cloud/latest/developerguide/build-job-bundle.html
"""

import json
import os
from collections.abc import Sequence
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.deliver.farm.job import FarmJob, Needs, Place, Step, Word, word_text
from heatlens.media.files.atomic_file import make_folder, write_whole

# Limits of the schema: values of a task parameter, characters in one, characters of a job's name,
# steps of a job.
_TASKS_MOST, _TEXT_MOST, _NAME_MOST, _STEPS_MOST = 1024, 1024, 128, 100
_MIB_PER_GIB = 1024


def job_template(job: FarmJob, folder: Path | None) -> str:
    """Return the template as YAML.

    Paths below `folder`, where the template will lie, have a default; None if they are told beside
    the template. Raises InputError for what a template cannot hold.
    """
    steps = _steps(job)
    if len(steps) > _STEPS_MOST:
        raise InputError(
            f"{job.count} tasks of {len(job.steps)} shots are too many; a job has at most "
            f"{_STEPS_MOST} steps of {_TASKS_MOST}. Give a larger --chunk, or fewer shots."
        )
    definitions = [_definition(place, folder) for place in job.places]
    return _document(
        {
            "specificationVersion": "jobtemplate-2023-09",
            "name": _printable(f"heatlens {job.name}"[:_NAME_MOST]),
            **({"parameterDefinitions": definitions} if definitions else {}),
            "steps": steps,
        }
    )


def write_bundle(job: FarmJob, folder: Path) -> None:
    """Write a job bundle, which `deadline bundle submit` and `openjd run` take."""
    values = {place.name: _printable(str(place.path)) for place in job.places}
    listed = [{"name": name, "value": value} for name, value in values.items()]
    out = [str(place.path) for place in job.places if place.flow == "OUT"]
    assets = {
        "inputs": {"filenames": [str(path) for path in job.inputs], "directories": []},
        "outputs": {"directories": out},
        "referencedPaths": [],
    }
    texts = {
        "parameters.json": json.dumps(values, indent=2, ensure_ascii=False) + "\n",
        "parameter_values.yaml": _document({"parameterValues": listed}),
        "asset_references.yaml": _document({"assetReferences": assets}),
        "template.yaml": job_template(job, None),
    }
    make_folder(folder)
    for name, text in texts.items():
        write_whole(folder / name, text.encode("utf-8"))


def _steps(job: FarmJob) -> list[dict[str, object]]:
    """Return steps with at most as many tasks as a step may have, then the one that waits."""
    made = [_step(step, job.needs) for step in job.steps_of(_TASKS_MOST)]
    if job.last is not None:
        waits = {"dependencies": [{"dependsOn": step["name"]} for step in made]}
        made.append({**_step(job.last, job.needs), **waits})
    return made


def _step(step: Step, needs: Needs) -> dict[str, object]:
    space = {"parameterSpace": _parameters(step.parts)} if step.parts else {}
    return {"name": _printable(step.name), **space, **_script(step.words, needs)}


def _parameters(parts: Sequence[str]) -> dict[str, object]:
    if max(map(len, parts)) > _TEXT_MOST:
        raise InputError("These frames are too irregular for one task. Give a smaller --chunk.")
    frames = {"name": "Frames", "type": "STRING", "range": list(parts)}
    return {"taskParameterDefinitions": [frames]}


def _script(words: Sequence[Word], needs: Needs) -> dict[str, object]:
    amounts = {
        "vcpu": needs.processors,
        **({} if needs.memory_gib is None else {"memory": needs.memory_gib * _MIB_PER_GIB}),
        **({"gpu": needs.gpus} if needs.gpus else {}),
    }
    wished = [{"name": f"amount.worker.{name}", "min": least} for name, least in amounts.items()]
    args = [*map(_text, words), "--progress=openjd"]
    run = {"onRun": {"command": "heatlens", "args": args}}
    return {"hostRequirements": {"amounts": wished}, "script": {"actions": run}}


def _text(word: Word) -> str:
    return word_text(word, lambda it: f"{{{{Param.{it.name}}}}}", "{{Task.Param.Frames}}", _plain)


def _plain(text: str) -> str:
    if "{{" in text:
        raise InputError("A template cannot hold a name or an option with {{ in it.")
    return _printable(text)


def _printable(text: str) -> str:
    if not text.isprintable():
        raise InputError("A template can hold only printable names. Rename the file.")
    return text


def relative_to(place: Place, folder: Path) -> str | None:
    """Return the path relative to `folder`; None if it is outside."""
    relative = os.path.relpath(place.path, folder)
    return None if relative.startswith(os.pardir) else Path(relative).as_posix()


def _definition(place: Place, folder: Path | None) -> dict[str, str]:
    """Return a parameter. Beside a bundle's list of files, whole folders need not be brought."""
    relative = None if folder is None else relative_to(place, folder)
    default = {} if relative is None else {"default": _printable(relative)}
    is_listed = folder is None and place.kind == "DIRECTORY" and place.flow == "IN"
    flow = {"objectType": place.kind, "dataFlow": "NONE" if is_listed else place.flow}
    return {"name": place.name, "type": "PATH", **flow, **default}


def _document(value: object) -> str:
    return "\n".join(_yaml(value)) + "\n"


def _yaml(value: object) -> list[str]:
    """Return lines of YAML in block style; texts are quoted as in JSON, a subset of YAML."""
    if isinstance(value, dict):
        return [line for name, entry in value.items() for line in _yaml_entry(name, entry)]
    if isinstance(value, list) and value:
        return [line for item in value for line in _indented(_yaml(item), "- ")]
    return [json.dumps(value, ensure_ascii=False)]


def _yaml_entry(name: str, value: object) -> list[str]:
    if isinstance(value, dict | list) and value:
        return [f"{name}:", *_indented(_yaml(value), "  ")]
    return [f"{name}: {_yaml(value)[0]}"]


def _indented(lines: list[str], first: str) -> list[str]:
    return [f"{first}{lines[0]}", *(f"  {line}" for line in lines[1:])]
