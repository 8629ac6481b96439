"""Studio: the program that a director sits before, with and without a window.

`settings` are what the user chose and kept; `session` does the work on them, and `board` is
what every front end drives: `ui`, the window in ImGui and GLFW, and `share`, which shows a
session to browsers, whose page is in `web`.
No code here prints, parses options or knows the Python interface.
"""
