"""A thing that no frame has, in the window and the page: the sentence is shown, not a picture."""

import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from support.evening import begun, until
from support.mattes import matte_plate


@pytest.mark.parametrize("option", ["never_blur", "only_blur", "flat_depth"])
def test_a_misspelt_thing_is_told(tmp_path, option):
    plate = matte_plate(tmp_path / "p.1001.exr", 3.0)
    session = begun(tmp_path / "preferences")
    try:
        options = PlateOptions(**{option: "cryptomatte:heor"})
        session.files.commands.open(str(plate), options)
        until(session, lambda: "Did you mean hero?" in session.messages.text, "the sentence")
        assert session.source.plate is None
    finally:
        session.close()
