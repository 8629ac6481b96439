"""What the window needs beside OpenGL: its libraries, fonts and a display."""

from collections.abc import Iterator

from heatlens.doctor.finding import Finding

_INSTALL = "pip install 'heatlens[gui]', on Debian or Ubuntu also: apt-get install libgl1 libegl1"


def fonts() -> Iterator[Finding]:
    """Look for the fonts that come with the library of the window."""
    try:
        from heatlens.ui.window_try import fonts_found
    except ImportError as error:
        yield Finding("fonts", "note", f"no window ({error}). {_INSTALL}")
        return
    yield Finding("fonts", "ok", fonts_found())


def display() -> Iterator[Finding]:
    """Open a window that nobody sees, and close it again."""
    try:
        from heatlens.ui.window_try import display_named, renderer_of_a_window
    except ImportError as error:
        yield Finding("display", "note", f"no window ({error}). {_INSTALL}")
        return
    named = display_named()
    if named is None:
        yield Finding("display", "note", "none here; `heatlens render` works without")
        return
    details = {"display": named, "renderer": renderer_of_a_window()}
    yield Finding("display", "ok", f"{named}, drawn by {details['renderer']}", details)
