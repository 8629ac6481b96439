"""A whole study as a value, for its page and its numbers."""

from dataclasses import dataclass

from heatlens.measure.study.measured import Row
from heatlens.measure.study.reference import Reference
from heatlens.model.boxes import Box
from heatlens.plate.plate import FloatImage


@dataclass(frozen=True, eq=False)
class Report:
    """The values of a whole report: the subject and the results.

    title     the name of the source
    facts     what all the pictures have in common, as (label, value)
    reference the picture that the rows are compared with
    sharp     the picture before the lens (H, W, 3) over the same region, None where there is none
    rows      the methods, the closest to the reference first
    left_out  a sentence for each method that is missing
    crops     places to look at, in pixels of the reference
    gain      factor by which the differences are brightened
    machine   the name of the renderer that the times belong to
    """

    title: str
    facts: tuple[tuple[str, str], ...]
    reference: Reference
    sharp: FloatImage | None
    rows: tuple[Row, ...]
    left_out: tuple[str, ...]
    crops: tuple[Box, ...]
    gain: float
    machine: str

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of all its pictures."""
        return self.reference.region.width, self.reference.region.height

    @property
    def best(self) -> Row:
        """The nearest to the reference, except a method that is the reference itself."""
        if self.reference.is_truth:
            return self.rows[0]
        return next((row for row in self.rows if row.scores.flip > 0), self.rows[0])
