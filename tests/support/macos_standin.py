"""Stand in for macOS: modules of heatlens see Python's library with the names that it has there.

It finds names, not behaviour. What draws or opens a window by OpenGL is missing.
"""

import os
import platform
import signal
import socket
import sys

from support.windows_standin import Partial, hand_out

_OS = """
    memfd_create sched_getaffinity sched_setaffinity pidfd_open eventfd copy_file_range getrandom
    O_TMPFILE O_PATH O_DIRECT posix_fadvise posix_fallocate pipe2 splice unshare setns getresuid
    fdatasync getxattr setxattr listxattr removexattr
""".split()
_SIGNAL = "sigtimedwait sigwaitinfo SIGRTMIN SIGRTMAX SIGPWR SIGCLD SIGPOLL SIGSTKFLT".split()
_SOCKET = "AF_NETLINK AF_PACKET AF_VSOCK SOCK_CLOEXEC SOCK_NONBLOCK MSG_NOSIGNAL".split()
OF_OPENGL = frozenset({"moderngl", "glcontext", "glfw", "imgui_bundle"})


def install() -> None:
    """Hand these modules to whatever heatlens imports in this process."""
    swaps = {
        "os": Partial(os, _OS),
        "sys": Partial(sys, platform="darwin"),
        "signal": Partial(signal, _SIGNAL),
        "socket": Partial(socket, _SOCKET),
        "platform": Partial(platform, system=lambda: "Darwin"),
    }
    hand_out(swaps, OF_OPENGL)
