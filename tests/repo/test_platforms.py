"""Test that the names of one system stand in few files, and that none is asked for on another.

The tests read the sources and Python's own stubs; nothing here runs on another system.
"""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import heatlens
from support.windows_names import LACKING, LACKING_BEFORE_3_12, MISSING_MODULES

PACKAGE = Path(heatlens.__file__).parent
SOURCES = {
    path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8")
    for path in sorted(PACKAGE.rglob("*.py"))
}
# The files that use what only one system has, and may ask on which one they run.
OF_SYSTEMS = {
    "core/base/memory.py",  # memory of the machine and of processes
    "core/base/paths.py",  # whose file it is
    "core/base/stopping.py",  # the end of the parent process
    "core/base/windows_calls.py",
    "deliver/farm/cluster.py",  # a terminal that is closed
    "fronts/api/engine.py",  # a fork
    "fronts/commands/doctor.py",  # the load
    "fronts/commands/worker_process.py",  # the second process
    "core/base/processes.py",  # whether a process has ended
    "media/files/atomic_file.py",  # links are not followed
    "media/files/file_lock.py",
    "media/files/limits.py",  # limits of a process
    "media/files/quiet.py",  # C's own buffer
    "studio/ui/devices.py",  # X11
}
_LIBRARY = re.compile(r"\bctypes\.(CDLL|WinDLL|windll|util)\b|[\"'(]/(proc|dev|sys)/")
_STUBBED = re.compile(
    r"^\s*(?:import|from) (?:os|sys|signal|socket|ctypes|select|subprocess|time|threading|asyncio|"
    r"mmap|multiprocessing|tempfile|shutil|platform|resource|fcntl|pwd|termios)\b",
    re.MULTILINE,
)


_POSIX = {
    module: LACKING[module] | LACKING_BEFORE_3_12.get(module, frozenset()) for module in LACKING
}
_ALL_POSIX = frozenset().union(*_POSIX.values())
_WORDS = re.compile(rf"\b({'|'.join(_ALL_POSIX | MISSING_MODULES)})\b")


def names_of_systems(source: str) -> set[str]:
    """Return what `source` uses of the names, modules and places that only one system has."""
    found = {match[0] for match in _LIBRARY.finditer(source)}
    for node in ast.walk(ast.parse(source)) if _WORDS.search(source) else ():
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names} & MISSING_MODULES
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = node.value.id
            found |= {f"{module}.{node.attr}"} if node.attr in _POSIX.get(module, ()) else set()
        elif isinstance(node, ast.Constant) and node.value in _ALL_POSIX:
            found.add(str(node.value))  # of getattr
    return found


def test_names_of_one_system_stand_in_few_files():
    users = {name: found for name, text in SOURCES.items() if (found := names_of_systems(text))}
    assert {name: found for name, found in users.items() if name not in OF_SYSTEMS} == {}
    assert OF_SYSTEMS - users.keys() == set()


def opens_text_in_unknown_encoding(source: str) -> list[int]:
    """Return the lines of `source` that read or write text in the encoding of the system."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        and _opens_text(node)
        and not any(keyword.arg == "encoding" for keyword in node.keywords)
    ]


def _opens_text(call: ast.Call) -> bool:
    if isinstance(call.func, ast.Name) and call.func.id == "open":
        mode = [word.value for word in call.args[1:2] if isinstance(word, ast.Constant)]
        return not (mode and "b" in str(mode[0])) and len(call.args) < 4
    name = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    return (name == "read_text" and not call.args) or (name == "write_text" and len(call.args) == 1)


def test_text_files_are_utf_8_on_every_system():
    users = {
        name: lines
        for name, text in SOURCES.items()
        if re.search(r"open\(|(read|write)_text\(", text)
        and (lines := opens_text_in_unknown_encoding(text))
    }
    assert users == {}
    assert opens_text_in_unknown_encoding("p.read_text()\nopen(p)\nopen(p, 'rb')") == [1, 2]


def test_no_source_names_what_windows_has_from_python_3_12_on_only():
    """So heatlens does the same there with either version, and one is tried."""
    newer = re.compile(rf"\b({'|'.join(frozenset().union(*LACKING_BEFORE_3_12.values()))})\b")
    assert newer.search("os.set_blocking(0, True)")
    assert [name for name, text in SOURCES.items() if newer.search(text)] == []


def test_no_source_asks_for_os_name():
    """Type checkers understand `sys.platform`, and `os.name` they do not."""
    assert [name for name, text in SOURCES.items() if re.search(r"\bos\.name\b", text)] == []


def test_one_file_names_the_python_of_this_process():
    """The frozen program has none: whoever starts heatlens again goes through `own_command`."""
    users = [name for name, text in SOURCES.items() if "sys.executable" in text]
    assert users == ["core/base/own_command.py"]


@pytest.mark.parametrize(
    "platform, foreign", [("win32", "os.fork"), ("darwin", "os.memfd_create")], ids=str
)
def test_names_of_library_exist_on_system(platform, foreign, tmp_path):
    """`mypy --platform win32` checks the rest too, and takes six times as long."""
    sample = tmp_path / "sample.py"
    sample.write_text(f"import os\n{foreign}\n", encoding="utf-8")
    files = [str(PACKAGE / name) for name, text in SOURCES.items() if _STUBBED.search(text)]
    options = ("--config-file=", "--follow-imports=skip", "--ignore-missing-imports")
    command = [sys.executable, "-m", "mypy", "--platform", platform, *options]
    command += [f"--cache-dir={tmp_path}", *files, str(sample)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    missing = [line for line in run.stdout.splitlines() if "Module has no attribute" in line]
    assert [line.partition(":")[0] for line in missing] == [str(sample)], missing
    assert f"(checked {len(files) + 1} source files)" in run.stdout


def test_sample_names_are_found():
    source = "import fcntl\nos.fork()\ngetattr(signal, 'SIGHUP')\nctypes.CDLL(None)\np('/proc/1')"
    found = names_of_systems(source)
    assert found == {"fcntl", "os.fork", "SIGHUP", "ctypes.CDLL", "'/proc/"}
