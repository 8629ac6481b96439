"""Studio: the program that a director sits before, with and without a window.

`session` does everything that the window does; `ui` is its window, in ImGui and GLFW;
`share` shows a session to browsers, whose page is in `web`.
No code here prints, parses options or knows the Python interface.
"""
