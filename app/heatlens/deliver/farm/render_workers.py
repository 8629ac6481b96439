"""Choose the workers of a Dask cluster that render frames: those with one program."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from heatlens.core.base.errors import HeatlensError
from heatlens.deliver.farm.answers import answer_of
from heatlens.deliver.farm.dask_types import Client, Future
from heatlens.deliver.farm.frame_worker import (
    Program,
    answer_program,
    own_program,
    program_of_answer,
)
from heatlens.render.defocus.line_solver import SolverName

_CHECK_S = 1.0  # interval between checks for new and lost workers
_PRIORITY = 10  # of the question for a program: before all frames

ON_THIS_MACHINE = "Frames are rendered on this machine."


@dataclass(frozen=True)
class WorkersStatus:
    """What the window shows of a cluster.

    workers  addresses of the workers that render
    problem  message why no worker renders, or ""
    program  program of the workers, if it is not that of this machine
    """

    workers: tuple[str, ...] = ()
    problem: str = ""
    program: Program = ()


# Two graphics drivers draw the same frame with different last digits, and a shot should not mix
# them. So all workers that render have one program, if possible that of this machine, because
# the window renders frames too.
class RenderWorkers:
    """The workers of one connection, with the programs that they have reported."""

    def __init__(
        self,
        address: str,
        client: Client,
        own_driver: tuple[str, str, SolverName],
        wake: Callable[[], None],
    ) -> None:
        """Begin without workers; `wake` is called when the workers should be checked."""
        self._address, self._client, self._solver, self._wake = address, client, own_driver[2], wake
        self._own_program = own_program(*own_driver)
        self._programs: dict[str, Future] = {}  # futures of the program of each worker
        self._known_programs: dict[str, Program] = {}  # the programs that workers have reported
        self._failures: dict[str, str] = {}  # the messages of workers that could not report theirs
        self._next_check_s = 0.0  # time of the next check of the workers

    @property
    def should_check(self) -> bool:
        """True if `check` should be called: a second has passed, or a worker has answered."""
        return time.monotonic() >= self._next_check_s

    def check(self) -> WorkersStatus:
        """Ask new workers for their programs, and choose the workers that render.

        They are those with the program of this machine; if there are none, those with the program
        of the first worker.
        """
        self._next_check_s = time.monotonic() + _CHECK_S
        current_workers = self._client.scheduler_info(n_workers=-1)["workers"]
        self._programs = {
            it: future for it, future in self._programs.items() if it in current_workers
        }
        for worker in [it for it in current_workers if it not in self._programs]:
            task = {"pure": False, "workers": [worker], "priority": _PRIORITY}
            self._programs[worker] = self._client.submit(answer_program, self._solver, **task)
            self._programs[worker].add_done_callback(self._check_soon)
        self._learn_programs()
        return self._chosen()

    def _check_soon(self, _future: Future) -> None:
        """Have the workers checked in the next step, after one of them has answered."""
        self._next_check_s = 0.0
        self._wake()

    def _learn_programs(self) -> None:
        """Forget the programs of workers that are gone, and read those that have arrived."""
        self._known_programs = {
            it: program for it, program in self._known_programs.items() if it in self._programs
        }
        self._failures = {it: why for it, why in self._failures.items() if it in self._programs}
        for it, future in self._programs.items():
            is_new = it not in self._known_programs and it not in self._failures
            if is_new and future.status in ("finished", "error"):
                self._learn_program(it, future)

    def _learn_program(self, worker: str, future: Future) -> None:
        """Store the program of a worker, or the message of its failure."""
        try:
            answer = answer_of(future)
            if answer is not None:
                self._known_programs[worker] = program_of_answer(answer)
        except HeatlensError as error:
            self._failures[worker] = str(error)

    def _chosen(self) -> WorkersStatus:
        """Return the workers that render, all with the same program."""
        compatible = {
            it: worker_program
            for it, worker_program in self._known_programs.items()
            if worker_program[:2] == self._own_program[:2]
        }
        program = (
            self._own_program
            if self._own_program in compatible.values()
            else next(iter(compatible.values()), ())
        )
        workers = tuple(
            it for it, worker_program in compatible.items() if worker_program == program
        )
        is_waiting = any(future.status == "pending" for future in self._programs.values())
        problem = "" if workers or is_waiting else f"{self._no_worker_message} {ON_THIS_MACHINE}"
        return WorkersStatus(workers, problem, () if program == self._own_program else program)

    @property
    def _no_worker_message(self) -> str:
        """The message why no worker renders."""
        if not self._programs:
            return f"No worker is at {self._address}."
        return next(
            iter(self._failures.values()),
            f"The workers at {self._address} have another heatlens.",
        )
