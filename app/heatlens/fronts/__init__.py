"""Fronts: the ways into the program beside its window.

`commands` is the command line, `api` what `import heatlens` gives, and `doctor` checks a machine.
Each turns words or arguments into values and hands them on; none renders by itself.
No other wing imports a front, and none imports the laboratory: its commands are found by name.
"""
