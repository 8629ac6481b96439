"""Lab: what measures the program: benchmarks, studies and comparisons with a truth.

`measure` computes times, errors and charts; `commands` has `bench`, `study` and `compare`.
No wing imports it, and the program works without it.
It knows all other wings, as whoever measures must.
"""
