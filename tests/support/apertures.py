"""A Hypothesis strategy of apertures of every kind, for tests that hold for all of them."""

from hypothesis import strategies as st

from heatlens.core.model.lens.aperture import Aperture


def apertures() -> st.SearchStrategy[Aperture]:
    """Return a strategy of apertures that are not plain ellipses, with random properties."""
    return st.builds(
        Aperture,
        squeeze=st.floats(1.0, 2.0),
        blades=st.sampled_from((0, *range(3, 17))),
        blade_rotation_deg=st.floats(-360, 360),
        blade_curvature=st.floats(0.0, 1.0),
        cat_eye=st.floats(0.0, 1.0),
        rim=st.floats(-1.0, 1.0),
        stopped_down=st.floats(1.0, 4.0),
    ).filter(lambda aperture: not aperture.is_plain)
