"""How OpenUSD counts the lens of a camera."""

METERS_PER_UNIT = 0.01  # what USD takes for granted: focal lengths and apertures are in mm then


def millimetres(meters_per_unit: float) -> float:
    """How many units of a stage's cameras are in one mm; USD counts lenses in tenths of a unit."""
    return 1e-3 / meters_per_unit * 10
