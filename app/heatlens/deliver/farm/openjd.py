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
from heatlens.media.files.atomic_file import make_folder, write_atomically

# Limits of the schema: values of a task parameter, characters in one, characters of a job's name,
# steps of a job.
_MOST_TASKS, _MOST_CHARACTERS, _MOST_NAME_CHARACTERS, _MOST_STEPS = 1024, 1024, 128, 100
_MIB_PER_GIB = 1024


def job_template(job: FarmJob, folder: Path | None) -> str:
    """Return the template as YAML.

    `folder` is the folder of the template; paths below it get a default value. It is None for a job
    bundle, whose paths are in a file of their own. Raises InputError for a job that a template
    cannot hold.
    """
    steps = _steps(job)
    if len(steps) > _MOST_STEPS:
        raise InputError(
            f"{job.count} tasks of {len(job.steps)} shots are too many; a job has at most "
            f"{_MOST_STEPS} steps of {_MOST_TASKS}. Give a larger --chunk, or fewer shots."
        )
    definitions = [_path_parameter(place, folder) for place in job.places]
    return _yaml_document(
        {
            "specificationVersion": "jobtemplate-2023-09",
            "name": _check_printable(f"heatlens {job.name}"[:_MOST_NAME_CHARACTERS]),
            **({"parameterDefinitions": definitions} if definitions else {}),
            "steps": steps,
        }
    )


def write_bundle(job: FarmJob, folder: Path) -> None:
    """Write a job bundle, which `deadline bundle submit` and `openjd run` take."""
    values = {place.name: _check_printable(str(place.path)) for place in job.places}
    value_entries = [{"name": name, "value": value} for name, value in values.items()]
    output_folders = [str(place.path) for place in job.places if place.flow == "OUT"]
    assets = {
        "inputs": {"filenames": [str(path) for path in job.inputs], "directories": []},
        "outputs": {"directories": output_folders},
        "referencedPaths": [],
    }
    texts = {
        "parameters.json": json.dumps(values, indent=2, ensure_ascii=False) + "\n",
        "parameter_values.yaml": _yaml_document({"parameterValues": value_entries}),
        "asset_references.yaml": _yaml_document({"assetReferences": assets}),
        "template.yaml": job_template(job, folder=None),
    }
    make_folder(folder)
    for name, text in texts.items():
        write_atomically(folder / name, text.encode("utf-8"))


def _steps(job: FarmJob) -> list[dict[str, object]]:
    """Return the steps, split where they have too many tasks, then the one that waits for them."""
    step_records = [_step(step, job.needs) for step in job.split_steps(_MOST_TASKS)]
    if job.last is not None:
        dependencies = {"dependencies": [{"dependsOn": step["name"]} for step in step_records]}
        step_records.append({**_step(job.last, job.needs), **dependencies})
    return step_records


def _step(step: Step, needs: Needs) -> dict[str, object]:
    """Return a step of the template: its name, its tasks, and what they run. Raises InputError."""
    space = {"parameterSpace": _parameters(step.parts)} if step.parts else {}
    return {"name": _check_printable(step.name), **space, **_script(step.words, needs)}


def _parameters(parts: Sequence[str]) -> dict[str, object]:
    """Return the parameter space of a step: the frames of each task. Raises InputError."""
    if max(map(len, parts)) > _MOST_CHARACTERS:
        raise InputError("These frames are too irregular for one task. Give a smaller --chunk.")
    frames = {"name": "Frames", "type": "STRING", "range": list(parts)}
    return {"taskParameterDefinitions": [frames]}


def _script(words: Sequence[Word], needs: Needs) -> dict[str, object]:
    """Return the requirements of a step on its host, and the command that it runs."""
    amounts = {
        "vcpu": needs.processors,
        **({} if needs.memory_gib is None else {"memory": needs.memory_gib * _MIB_PER_GIB}),
        **({"gpu": needs.gpus} if needs.gpus else {}),
    }
    amount_requirements = [
        {"name": f"amount.worker.{name}", "min": least} for name, least in amounts.items()
    ]
    args = [*map(_word_template, words), "--progress=openjd"]
    run = {"onRun": {"command": "heatlens", "args": args}}
    return {"hostRequirements": {"amounts": amount_requirements}, "script": {"actions": run}}


def _word_template(word: Word) -> str:
    """Return a word of the command, with references to its parameter. Raises InputError."""
    return word_text(
        word, lambda it: f"{{{{Param.{it.name}}}}}", "{{Task.Param.Frames}}", _check_template_text
    )


def _check_template_text(text: str) -> str:
    """Return the text unchanged. Raises InputError if it could be read as a template variable."""
    if "{{" in text:
        raise InputError(
            "A job of Open Job Description cannot hold the characters {{: rename the file or leave "
            f"the option out, {text!r}."
        )
    return _check_printable(text)


def _check_printable(text: str) -> str:
    """Return the text unchanged. Raises InputError for control characters."""
    if not text.isprintable():
        raise InputError(
            "A job of Open Job Description cannot hold unprintable characters: rename the file "
            f"{text!r}."
        )
    return text


def relative_to(place: Place, folder: Path) -> str | None:
    """Return the path relative to `folder`; None if it is outside."""
    relative = os.path.relpath(place.path, folder)
    return None if relative.startswith(os.pardir) else Path(relative).as_posix()


def _path_parameter(place: Place, folder: Path | None) -> dict[str, str]:
    """Return the definition of a path parameter.

    A job bundle (`folder` is None) lists its input files; its input folders need no transfer.
    """
    relative = None if folder is None else relative_to(place, folder)
    default = {} if relative is None else {"default": _check_printable(relative)}
    is_listed = folder is None and place.kind == "DIRECTORY" and place.flow == "IN"
    flow = {"objectType": place.kind, "dataFlow": "NONE" if is_listed else place.flow}
    return {"name": place.name, "type": "PATH", **flow, **default}


def _yaml_document(value: object) -> str:
    return "\n".join(_yaml_lines(value)) + "\n"


def _yaml_lines(value: object) -> list[str]:
    """Return lines of YAML in block style; texts are quoted as in JSON, a subset of YAML."""
    if isinstance(value, dict):
        return [line for name, entry in value.items() for line in _yaml_entry_lines(name, entry)]
    if isinstance(value, list) and value:
        return [line for item in value for line in _indent(_yaml_lines(item), "- ")]
    return [json.dumps(value, ensure_ascii=False)]


def _yaml_entry_lines(name: str, value: object) -> list[str]:
    """Return the lines of one entry; a dict or a list begins below its name."""
    if isinstance(value, dict | list) and value:
        return [f"{name}:", *_indent(_yaml_lines(value), "  ")]
    return [f"{name}: {_yaml_lines(value)[0]}"]


def _indent(lines: list[str], first: str) -> list[str]:
    """Return the lines indented by two; `first`, of two letters, begins the first one."""
    return [f"{first}{lines[0]}", *(f"  {line}" for line in lines[1:])]
