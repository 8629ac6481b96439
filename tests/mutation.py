"""Change the program in one place at a time, and list the changes that no test of the area sees.

    python tests/mutation.py --rooms core/model studio/board --sample 300 --seed 28 --keep found

A mutant is one small change: another comparison, sum or number, a removed statement, a branch taken
the other way. It runs in a forked process against the tests of `tests/ROOM` that reach its line,
those that name its module first, then the fastest, until one fails. A mutant that survives shows
behaviour that nothing holds, or is equivalent: a change that nobody could see. Only the process
itself is changed; what it starts is not. Needs `pip install coverage`.
"""

import argparse
import ast
import collections
import contextlib
import importlib.abc
import importlib.util
import json
import os
import random
import re
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
APP = ROOT / "app" / "heatlens"
ROOMS = ("core/model", "render/defocus", "media/files", "studio/board", "studio/session")
TESTS_S = 60.0  # tests of a mutant that need longer together are not all run
PATIENCE = 4  # a mutant hangs that needs so many times longer than its tests did, and 20 s
QUIETLY = ("-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning")
WARM = ("numpy", "moderngl", "hypothesis", "OpenEXR", "PIL.Image", "av", "PyOpenColorIO")
COMPARISONS = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
SUMS = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Div,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
}
REMOVED = (ast.Assign, ast.AugAssign, ast.Raise, ast.Continue, ast.Break)
Change = Callable[[], None]  # changes the tree that it was found in
Found = tuple["Place", str, Change]


@dataclass(frozen=True)
class Place:
    """Where a node stands: the lines of its statement, and whether an import runs them."""

    lines: tuple[int, ...] = ()
    at_import: bool = True


@dataclass(frozen=True)
class Mutant:
    """One change: the `number`-th of those that `changes` finds in the file at `path` of a room."""

    room: str
    path: Path
    number: int
    place: Place
    words: str

    @property
    def name(self) -> str:
        return f"{self.path.relative_to(APP)}:{self.place.lines[0]} {self.words}"

    @property
    def module(self) -> str:
        dotted = ".".join(self.path.relative_to(APP.parent).with_suffix("").parts)
        return dotted.removesuffix(".__init__")

    def code(self) -> Any:
        tree = ast.parse(self.path.read_text(encoding="utf-8"))
        for number, (_, _, change) in enumerate(changes(tree, Place())):
            if number == self.number:
                change()
                break
        return compile(ast.fix_missing_locations(tree), str(self.path), "exec")


def changes(node: ast.AST, at: Place) -> Iterator[Found]:
    """Yield what can be changed in and below a node."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        below = _place(node, field, at)
        for i, item in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(item, ast.AST) and not _is_left_alone(item):
                put = partial(value.__setitem__, i) if isinstance(value, list) else None
                place = _place_of(item, below)
                for words, new in _others(item, place):
                    yield place, words, partial(put or partial(setattr, node, field), new)
                yield from changes(item, place)


def _place(node: ast.AST, field: str, at: Place) -> Place:
    """Return where a field of a node runs: defaults belong to the lines of the function."""
    if isinstance(node, ast.FunctionDef) and field in ("args", "body"):
        lines = tuple(range(node.body[0].lineno, (node.end_lineno or 0) + 1))
        return Place(lines, at_import=False)
    return at


def _place_of(node: ast.AST, at: Place) -> Place:
    if not isinstance(node, ast.stmt):
        return at
    body = getattr(node, "body", None)
    end = max(node.lineno, body[0].lineno - 1) if body else node.end_lineno or node.lineno
    return Place(tuple(range(node.lineno, end + 1)), at.at_import)


def _is_left_alone(node: ast.AST) -> bool:
    """Tell what is no behaviour: guards of imports, and checks of lengths that always hold."""
    return isinstance(node, ast.keyword) and node.arg == "strict"


def _others(node: ast.AST, at: Place) -> Iterator[tuple[str, ast.AST]]:
    """Yield what may stand in the place of a node, in words and as a node."""
    for new in [*_other_values(node), *_other_statements(node, at)]:
        ast.copy_location(new, node)
        yield f"{_short(node)} -> {_short(new)}", new


def _other_values(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Compare):
        for i, sign in enumerate(node.ops):
            for other in COMPARISONS[type(sign)]:
                signs = [*node.ops[:i], other(), *node.ops[i + 1 :]]
                yield ast.Compare(node.left, signs, node.comparators)
    elif isinstance(node, ast.BinOp) and type(node.op) in SUMS:
        yield ast.BinOp(node.left, SUMS[type(node.op)](), node.right)
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield node.operand
    elif isinstance(node, ast.Constant):
        yield from map(ast.Constant, _other_constants(node.value))
    elif isinstance(node, ast.IfExp):
        yield ast.IfExp(node.test, node.orelse, node.body)
    elif isinstance(node, ast.comprehension) and node.ifs:
        yield ast.comprehension(node.target, node.iter, [], node.is_async)


def _other_constants(value: object) -> list[object]:
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int | float):
        return [
            new for new in dict.fromkeys([value * 2, value + 1, type(value)(0)]) if new != value
        ]
    return []


def _other_statements(node: ast.AST, at: Place) -> Iterator[ast.AST]:
    if isinstance(node, ast.If):
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            yield ast.If(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
    elif at.at_import:
        return  # a removed name is an error of the import
    elif isinstance(node, ast.Return) and not isinstance(node.value, ast.Constant | None):
        yield ast.Return(ast.Constant(None))
    elif isinstance(node, REMOVED) or (
        isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)
    ):
        yield ast.Pass()


def _short(node: ast.AST) -> str:
    if isinstance(node, ast.If):
        return f"if {ast.unparse(node.test)}"
    if isinstance(node, ast.comprehension):
        return f"for {ast.unparse(node.target)}{' if' * len(node.ifs)}"
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= 70 else text[:67] + "..."


def mutants(room: str) -> list[Mutant]:
    made = []
    for path in sorted((APP / room).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found = enumerate(changes(tree, Place()))
        made += [Mutant(room, path, i, place, words) for i, (place, words, _) in found]
    return made


def sampled(rooms: Sequence[str], count: int, seed: int) -> list[Mutant]:
    """Return mutants of different lines, as many of each room as its part of all lines."""
    chance, chosen = random.Random(seed), []
    sizes = {
        r: sum(len(p.read_text().splitlines()) for p in (APP / r).rglob("*.py")) for r in rooms
    }
    for room, size in sizes.items():
        lines = collections.defaultdict(list)
        for mutant in mutants(room):
            lines[mutant.path, mutant.place.lines[0]].append(mutant)
        wanted = round(count * size / sum(sizes.values()))
        for line in chance.sample(sorted(lines), min(wanted, len(lines))):
            chosen.append(chance.choice(lines[line]))
    chance.shuffle(chosen)  # a run that is ended has seen some of each room
    return chosen


class Recording:
    """Notes which test reaches which line, and how long each takes."""

    def __init__(self, coverage: Any) -> None:
        self.coverage = coverage
        self.seconds: dict[str, float] = collections.defaultdict(float)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self.coverage.switch_context(item.nodeid.partition("::")[0])  # a fixture is of its file

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_call(self, item: pytest.Item) -> None:
        self.coverage.switch_context(item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] += report.duration


class Chosen:
    """Runs the chosen tests in their order, and does not look for smaller examples."""

    def __init__(self, tests: Sequence[str], known: dict[str, float]) -> None:
        self.order = {test: i for i, test in enumerate(tests)}
        self.known = known

    def pytest_configure(self) -> None:
        from hypothesis import Phase, settings

        phases = (Phase.explicit, Phase.generate)
        settings.register_profile("mutants", settings.get_profile("repeated"), phases=phases)
        settings.load_profile("mutants")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        # A case that is not known has its name from what the mutant changed.
        kept = [i for i in items if i.nodeid in self.order or i.nodeid not in self.known]
        items[:] = sorted(kept, key=lambda item: self.order.get(item.nodeid, -1))


class MutantFinder(importlib.abc.MetaPathFinder):
    """A finder that imports the changed module instead of the one in the file."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant

    def find_spec(self, name: str, path: object, target: object = None) -> Any:
        if name != self.mutant.module:
            return None
        loader = SourceFileLoader(name, str(self.mutant.path))
        loader.get_code = lambda _name: self.mutant.code()  # type: ignore[method-assign]
        return importlib.util.spec_from_file_location(name, self.mutant.path, loader=loader)


def forked(work: Callable[[], int], limit_s: float, log: Path) -> int | None:
    """Return the exit code of work that runs in a process of its own; None where it was ended."""
    child = os.fork()
    if child == 0:
        code = 99
        try:
            os.setsid()
            with log.open("w") as out:
                os.dup2(out.fileno(), 1)
                os.dup2(out.fileno(), 2)
            code = int(work())
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stderr.flush()
            os._exit(code)
    ends = time.monotonic() + limit_s
    status = (0, 0)
    while status[0] == 0 and time.monotonic() < ends:
        time.sleep(0.05)
        status = os.waitpid(child, os.WNOHANG)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # with what it started
    if status[0] == 0:
        os.waitpid(child, 0)
        return None
    return os.waitstatus_to_exitcode(status[1])


def recorded(room: str, keep: Path) -> dict[str, Any]:
    """Return which tests of a room reach which line, from the last run where that is kept."""
    kept = keep / f"{room.replace('/', '-')}.json"
    if not kept.exists():
        log = kept.with_suffix(".log")
        if forked(partial(_record, room, kept), 3600.0, log) != 0:
            raise SystemExit(f"the tests of {room} do not pass: see {log}")
    return json.loads(kept.read_text())


def _record(room: str, kept: Path) -> int:
    from coverage import Coverage

    coverage = Coverage(data_file=None, source=[str(APP / room)], config_file=False)
    coverage.start()
    recording = Recording(coverage)
    code = pytest.main(["-q", *QUIETLY, f"tests/{room}"], [recording])
    coverage.stop()
    data = coverage.get_data()
    reach = {
        str(Path(p).relative_to(ROOT)): data.contexts_by_lineno(p) for p in data.measured_files()
    }
    kept.write_text(json.dumps({"seconds": recording.seconds, "reach": reach}))
    return code


def reaching(mutant: Mutant, record: dict[str, Any]) -> list[str]:
    """Return the tests that reach a mutant: those that name its module first, then the fastest."""
    found = set(_contexts(mutant, record))
    seconds = record["seconds"]
    tests = [t for t in seconds if t in found or t.partition("::")[0] in found]
    of_file: dict[str, float] = collections.Counter()
    for test in tests:
        of_file[test.partition("::")[0]] += seconds[test]

    def order(test: str) -> tuple[bool, float, str, float]:
        file = test.partition("::")[0]
        return not _names(file, mutant.path.stem), of_file[file], file, seconds[test]

    return sorted(tests, key=order)


def _contexts(mutant: Mutant, record: dict[str, Any]) -> Iterator[str]:
    own = str(mutant.path.relative_to(ROOT))
    lines = record["reach"].get(own, {})
    at_line = {context for line in mutant.place.lines for context in lines.get(str(line), ())}
    if not mutant.place.at_import and "" not in at_line:
        yield from at_line
        return
    for path, lines in record["reach"].items():  # an import runs it: whoever uses what it makes
        for line, contexts in lines.items():
            if path == own or _mentions(path, int(line), mutant):
                yield from contexts


def _mentions(path: str, line: int, mutant: Mutant) -> bool:
    """Tell whether a line of another file holds the name that a mutant gives a new value."""
    name = re.match(r"\s*(\w+)\s*[:=]", _line(str(mutant.path), mutant.place.lines[0]))
    return bool(name) and re.search(rf"\b{name[1]}\b", _line(path, line)) is not None


def _line(path: str, number: int) -> str:
    return dict(enumerate(_lines(path), start=1)).get(number, "")


@cache
def _lines(path: str) -> list[str]:
    return (ROOT / path).read_text(encoding="utf-8").splitlines()


@cache
def _names(test_file: str, module: str) -> bool:
    return module in (ROOT / test_file).read_text(encoding="utf-8")


def end_of(mutant: Mutant, record: dict[str, Any], log: Path) -> str:
    """Return what came of a mutant: killed, survived, hung, or reached by no test."""
    tests, spent = [], 0.0
    for test in reaching(mutant, record):
        spent += record["seconds"][test]
        if tests and spent > TESTS_S:
            break
        tests.append(test)
    if not tests:
        return "unreached"
    code = forked(partial(_run, mutant, tests, record["seconds"]), 20 + PATIENCE * spent, log)
    return {0: "survived", None: "hung"}.get(code, "killed")


def _run(mutant: Mutant, tests: Sequence[str], known: dict[str, float]) -> int:
    sys.meta_path.insert(0, MutantFinder(mutant))
    files = dict.fromkeys(test.partition("::")[0] for test in tests)
    return pytest.main(["-xq", *QUIETLY, *files], [Chosen(tests, known)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rooms", nargs="+", default=ROOMS, metavar="ROOM")
    parser.add_argument("--sample", type=int, default=300, help="how many mutants")
    parser.add_argument("--seed", type=int, default=28)
    parser.add_argument(
        "--keep", type=Path, default=Path("mutants"), help="folder of what is found"
    )
    wishes = parser.parse_args()
    wishes.keep.mkdir(parents=True, exist_ok=True)
    os.chdir(ROOT)
    sys.path[:0] = [str(APP.parent)]
    for name in WARM:  # once, not in each of the processes
        importlib.import_module(name)
    records = {room: recorded(room, wishes.keep) for room in wishes.rooms}
    chosen = sampled(wishes.rooms, wishes.sample, wishes.seed)
    ends: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    results = wishes.keep / f"seed-{wishes.seed}.jsonl"
    known = dict(map(json.loads, results.read_text().splitlines())) if results.exists() else {}
    for i, mutant in enumerate(chosen):
        if mutant.name not in known:  # a run that was ended goes on
            known[mutant.name] = end_of(mutant, records[mutant.room], wishes.keep / "last.log")
            with results.open("a") as out:
                out.write(json.dumps([mutant.name, known[mutant.name]]) + "\n")
        ends[mutant.room][known[mutant.name]] += 1
        print(f"{i + 1}/{len(chosen)} {known[mutant.name]} {mutant.name}", flush=True)
    for room, counts in ends.items():
        lived = counts["survived"] + counts["unreached"]
        print(f"{room}: {lived} of {counts.total()} live, {dict(counts)}")


if __name__ == "__main__":
    main()
