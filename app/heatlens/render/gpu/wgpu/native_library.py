"""Import the C library of wgpu with declarations that were parsed before.

wgpu parses the header of its library at every start, and the names of all its types again for each
structure that it makes for the first time: 1.5 s of a render. cffi can parse a header once; what it
found is kept in the user's cache folder. Where that fails, wgpu does it in its own way.
"""

import ast
import hashlib
import importlib
import io
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import _cffi_backend
import cffi
import wgpu

from heatlens.core.base.errors import GpuError
from heatlens.core.base.log import LOG
from heatlens.core.base.paths import compiled_shaders_dir, read_file_bytes
from heatlens.media.files.kept_files import keep_file, read_kept_file
from heatlens.render.gpu.device import DeviceError, DeviceLostError
from heatlens.render.gpu.wgpu.spirv import SHADERS_MOST_BYTES

_HEADER = Path(wgpu.__file__).parent / "resources" / "combined_header.h"
_BACKEND = "wgpu.backends.wgpu_native"
_DAMAGED = (OSError, SyntaxError, TypeError, ValueError)


class _ParsedHeader(_cffi_backend.FFI):  # type: ignore[misc]
    """Declarations that were parsed before, with what wgpu calls of `cffi.FFI`."""

    def cdef(self, _header: str) -> None:
        """Do nothing: all is declared."""

    def set_source(self, *_words: object) -> None:
        """Do nothing: no source is written."""


def import_native_library() -> None:
    """Import the library, and let it raise and log errors in the way of heatlens."""
    _import()
    helpers: Any = importlib.import_module(f"{_BACKEND}._helpers")
    helpers.ERROR_TYPES = dict.fromkeys(helpers.ERROR_TYPES, _device_error)
    _trust_loops(importlib.import_module(f"{_BACKEND}._api"))
    logger = logging.getLogger("wgpu")
    logger.parent, logger.handlers[:] = LOG, []


def _trust_loops(api: Any) -> None:
    """Let shaders be translated without counters that end loops which never would.

    Drivers do not unroll loops with such a counter, and Mesa's rasterizer ends all loops of an
    invocation after 65,535 iterations in all.
    """
    trusted, bounds_checks = api.libf.wgpuDeviceCreateShaderModuleTrusted, 1
    api.libf.wgpuDeviceCreateShaderModule = lambda *words: trusted(*words, bounds_checks)


def _device_error(message: str) -> GpuError:
    """Return the error for what wgpu says, whose last line has the cause."""
    if "device is lost" in message:
        return DeviceLostError(
            "The graphics device was lost: its driver was started anew, or it was taken away. "
            "Start heatlens again."
        )
    cause = message.rstrip().rpartition("\n")[2].strip().rstrip(".")
    sentence = f"wgpu refused to go on: {cause}. `heatlens doctor` checks this machine."
    if "memory" in cause.lower():
        sentence = f"wgpu has too little memory ({cause}). A smaller --proxy needs less."
    return DeviceError(sentence, cause, details=" ".join(message.split()))


def _import() -> None:
    """Import the library, which keeps the way in which it was imported first."""
    try:
        parsed = _parsed_header()
    except (AttributeError, *_DAMAGED) as error:  # other versions of wgpu or cffi
        LOG.debug("wgpu parses its header itself: %s", error)
        importlib.import_module(_BACKEND)
        return
    with _in_place_of_parser(parsed):
        importlib.import_module(_BACKEND)


@contextmanager
def _in_place_of_parser(parsed: _ParsedHeader) -> Iterator[None]:
    """Let what is imported inside get the parsed header where it asks for a parser."""
    parser = cffi.FFI
    cffi.FFI = lambda: parsed
    try:
        yield
    finally:
        cffi.FFI = parser


def _parsed_header() -> _ParsedHeader:
    """Return the parsed header, from the cache folder if it is there."""
    header = read_file_bytes(_HEADER)
    key = hashlib.sha256(header + cffi.__version__.encode()).hexdigest()[:32]
    file = compiled_shaders_dir() / f"{key}.cffi"
    kept = read_kept_file(file)
    if kept is not None:
        try:
            return _ParsedHeader("wgpu", **ast.literal_eval(kept.decode()))
        except _DAMAGED as error:
            LOG.debug("%s is damaged: %s", file, error)
    words = _parse(header.decode())
    keep_file(file, repr(words).encode(), SHADERS_MOST_BYTES)
    return _ParsedHeader("wgpu", **words)


def _parse(header: str) -> dict[str, Any]:
    """Return what cffi finds in a header, as the arguments of its compiled FFI."""
    from cffi.recompiler import make_py_source

    parser, source = cffi.FFI(), io.StringIO()
    parser.cdef(header)
    parser.set_source("wgpu", None)
    make_py_source(parser, "wgpu", source)
    (call,) = (node for node in ast.walk(ast.parse(source.getvalue())) if type(node) is ast.Call)
    return {str(word.arg): ast.literal_eval(word.value) for word in call.keywords}
