"""Describe an export as a shell script that submits it to Slurm.

https://slurm.schedmd.com/sbatch.html
"""

from collections.abc import Sequence
from shlex import quote

from heatlens.deliver.farm.job import FarmJob, Needs, Step, Word, word_text

_MOST_ARRAY_TASKS = 1000  # tasks of an array: MaxArraySize is 1001 unless a site changes it

_HEAD = """\
#!/bin/sh
# {name}: {tasks} tasks. Submit them with: sh THIS_FILE
jobs=
fail() {{
  test -z "$jobs" || scancel $jobs
  echo "heatlens: $1" >&2
  exit 2
}}
submit() {{
  id=$(sbatch --parsable --requeue --kill-on-invalid-dep=yes {options} "$@") ||
    fail 'Slurm did not take the job, see the line above. Nothing is left of it in the queue.'
  jobs="$jobs ${{id%%;*}}"
}}
command -v sbatch >/dev/null || fail 'sbatch is not here: run this where Slurm takes jobs.'
"""
_TASKS = """\
set -- {parts}
shift "$SLURM_ARRAY_TASK_ID"
"""


def slurm_script(job: FarmJob) -> str:
    """Return the script. It begins with a variable for each place, which all tasks receive."""
    head = _HEAD.format(
        name=quote(job.name).replace("\n", " "),
        tasks=job.count,
        options=" ".join(map(quote, _options(job.name, job.needs))),
    )
    places = [f"export heatlens_{place.name}={quote(str(place.path))}\n" for place in job.places]
    tasks = [
        _submit_command(_array_script(step), f"--array=0-{step.count - 1}")
        for step in job.split_steps(_MOST_ARRAY_TASKS)
    ]
    if job.last is not None:
        dependency = '--dependency="afterok$(printf :%s $jobs)"'
        tasks.append(_submit_command(_heatlens_command(job.last.words), dependency))
    return "".join([head, *places, *tasks, "echo $jobs\n"])


def _options(name: str, needs: Needs) -> list[str]:
    """Return the options of sbatch for the name and the needs of a step."""
    return [
        f"--job-name=heatlens {name}",
        f"--cpus-per-task={needs.processors}",
        *([] if needs.memory_gib is None else [f"--mem={needs.memory_gib}G"]),
        *([f"--gres=gpu:{needs.gpus}"] if needs.gpus else []),
    ]


def _submit_command(script: str, option: str) -> str:
    """Return the command that submits a script, as a here-document with an unused end mark."""
    end = "END"
    while end in script:
        end += "_"
    return f"submit {option} <<'{end}'\n#!/bin/sh\n{script}{end}\n"


def _array_script(step: Step) -> str:
    return _TASKS.format(parts=" ".join(step.parts)) + _heatlens_command(step.words)


def _heatlens_command(words: Sequence[Word]) -> str:
    """Return the line of the script that runs heatlens with these words."""

    def typed(word: Word) -> str:
        return word_text(word, lambda place: f'"$heatlens_{place.name}"', '"$1"', quote)

    return f"exec heatlens {' '.join(map(typed, words))}\n"
