"""Everything that is told in a sentence is one of these; `heatlens.faults` makes them of the rest.

What the user can mend ends a command with exit code 2.

HeatlensError
├── InputError    a file, a channel or an option: what was found and what would help
├── LensError     a lens that cannot be
├── GpuError      no usable OpenGL, or a picture larger than it takes
│   └── NoWindowError   no window can be opened here
├── ShaderError   a shader that does not compile: the file, the line and the driver's words
└── FaultError    a mistake of heatlens itself, which only a new version mends: exit code 70
"""


class HeatlensError(Exception):
    """One or two plain sentences for the person at the keyboard."""


class InputError(HeatlensError):
    """A file, channel or option cannot be used as given."""


class LensError(HeatlensError):
    """A lens that cannot be built: its values contradict physics or each other."""


class GpuError(HeatlensError):
    """No OpenGL 4.3, or a limit of it that the picture exceeds."""


class NoWindowError(GpuError):
    """There is no display, or none with OpenGL 4.3."""


class ShaderError(HeatlensError):
    """A shader failed to compile or link."""


class FaultError(HeatlensError):
    """heatlens made a mistake; the sentence names the file that holds the full report."""
