"""The errors that are shown to the user; `heatlens.core.base.faults` converts all others to these.

Errors that the user can fix end a command with exit code 2.

HeatlensError
├── InputError    a file, a channel or an option: what was found and what would help
│   └── MissingPackageError   a package of an optional part, and the command that installs it
├── LensError     an impossible lens
├── GpuError      nothing can draw here, or the picture is too large for it
│   └── NoWindowError   no window can be opened here
├── ShaderError   a shader that does not compile: the file, the line and the driver's message
└── FaultError    a bug of heatlens itself, which only a new version fixes: exit code 70

HeatlensWarning is not an error: it tells Python callers of doubts, which commands print.
"""

FAULT_CODE = 70  # EX_SOFTWARE of sysexits.h: an error within a program


class HeatlensError(Exception):
    """An error whose message is one or two plain sentences for the user."""


class InputError(HeatlensError):
    """A file, channel or option cannot be used as given."""


class MissingPackageError(InputError):
    """A package cannot be imported; the message says which command installs it."""


class LensError(HeatlensError):
    """An impossible lens: its values contradict physics or each other."""


class GpuError(HeatlensError):
    """No graphics library can draw here, or the picture exceeds a limit of it."""


class NoWindowError(GpuError):
    """There is no display, or none that a window can be drawn on."""


class ShaderError(HeatlensError):
    """A shader failed to compile or link."""


class FaultError(HeatlensError):
    """A bug of heatlens; the message names the file with the full report."""


class HeatlensWarning(UserWarning):
    """Something doubtful about a source or its lens, in one plain sentence; the picture is made."""
