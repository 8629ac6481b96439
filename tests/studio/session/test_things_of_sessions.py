"""A matte object that no frame has: the session shows a message and no picture."""

import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from support.evening import begin_session, run_until
from support.mattes import matte_plate


@pytest.mark.parametrize("option", ["never_blur", "only_blur", "flat_depth"])
def test_misspelled_matte_object_is_reported_with_a_suggestion(tmp_path, option):
    plate = matte_plate(tmp_path / "p.1001.exr", 3.0)
    session = begin_session(tmp_path / "preferences")
    try:
        options = PlateOptions(**{option: "cryptomatte:heor"})
        session.files.commands.open(str(plate), options)
        run_until(session, lambda: "Did you mean hero?" in session.messages.text, "the sentence")
        assert session.source.plate is None
    finally:
        session.close()
