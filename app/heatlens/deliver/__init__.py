"""Deliver: rendered frames become files, on this machine or on many.

`export` plans, renders and writes frames, movies and the pull sheet.
`farm` makes jobs for render farms, asks the workers of a cluster for frames, and runs an
export in a process of its own.
No code here knows of a session, a window or the words of the command line.
"""
