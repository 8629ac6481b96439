"""The origin of distances: the entrance pupil, as in a picture, or the film plane.

A tape and the scale on a lens begin at the film plane; the depth of a plate begins at the point
that the camera looks from, which is the entrance pupil. A shot keeps distances from the pupil;
those that people read, type and send start at the origin set on its lens.
"""

from enum import StrEnum


class MeasuredFrom(StrEnum):
    """The origin of the distances that people read and type."""

    PUPIL = "entrance-pupil"
    FILM = "film-plane"

    @property
    def words(self) -> str:
        """Its name in a sentence."""
        return str(self).replace("-", " ")

    def offset_m(self, pupil_offset_mm: float) -> float:
        """Return the amount by which a distance from here exceeds one from the pupil."""
        return 1e-3 * pupil_offset_mm if self is MeasuredFrom.FILM else 0.0
