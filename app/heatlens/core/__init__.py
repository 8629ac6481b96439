"""Core: the values of a shot, and what every program on a machine needs.

`model` is what a picture is made of: lens, curves, marks, shot, units; numpy alone, no files.
`base` is errors, paths, processes and parts that may be missing.
No code here knows of a plate, a scene, a GPU, a window or a command.
"""
