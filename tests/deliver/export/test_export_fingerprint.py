"""Test that the fingerprint of a frame depends on all that affects its pixels, and only on that."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Quality
from heatlens.deliver.export.job import DisplaySettings, ExportJob
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import fingerprint_of
from heatlens.media.sequence.sequence import StampedFile
from heatlens.render.source.source import Origin
from support.exports import FRAMES, QUICK, shot_of

JOB = ExportJob(shot=shot_of("plate.####.exr"), frames=FRAMES, output=parse_output("n.####.exr"))
LENS = Lens(50.0, 2.0, 2.0, 36.0)
PICTURES = replace(JOB, output=parse_output("n.####.png"))


def fingerprint(job=JOB, frame=1001, lens=LENS, stamp=(5, 6), is_black=False) -> str:
    file = StampedFile(Path("plate.exr"), stamp)
    return fingerprint_of(job, frame, lens, Origin(frame, is_black, (file,)))


@pytest.mark.parametrize(
    "changes",
    [
        {"frame": 1002},
        {"stamp": (5, 7)},
        {"stamp": (4, 6)},
        {"is_black": True},
        *(
            {"lens": replace(LENS, **{str(p): 1.9})}
            for p in LensParameter
            if p != "focal_length_mm"
        ),
        {"lens": replace(LENS, focal_length_mm=49.0)},
        {"lens": replace(LENS, sensor_width_mm=24.0)},
        {"lens": replace(LENS, focus_distance_m=float("inf"))},
        {"job": replace(JOB, options=ExportOptions(is_float=True))},
        {"job": replace(JOB, options=ExportOptions(compression="piz"))},
        {"job": replace(JOB, options=ExportOptions(with_depth=True))},
        {"job": replace(JOB, options=ExportOptions(with_coc=True))},
        {"job": replace(JOB, shot=replace(JOB.shot, defocus=replace(QUICK, layers=3)))},
        {"job": replace(JOB, shot=replace(JOB.shot, defocus=replace(QUICK, proxy=0.5)))},
        {"job": replace(JOB, shot=replace(JOB.shot, defocus=replace(QUICK, quality=Quality.FILM)))},
        {"job": replace(JOB, shot=replace(JOB.shot, plate_options=PlateOptions(near_m=1.0)))},
        {"job": PICTURES},
        {"job": replace(PICTURES, display_settings=DisplaySettings(exposure_stops=1.0))},
        {"job": replace(PICTURES, options=ExportOptions(burn_in=True))},
        {"job": replace(PICTURES, options=ExportOptions(burn_in=True, unit="ft"))},
        {"job": replace(PICTURES, options=ExportOptions(burn_in=True, burn_in_text="{frame}"))},
        {"job": replace(PICTURES, options=ExportOptions(burn_in=True, shot_name="a"))},
        {"job": replace(PICTURES, output=parse_output("n.####.jpg"))},
    ],
)
def test_fingerprint_changes_with_everything_that_affects_pixels(changes):
    assert fingerprint(**changes) != fingerprint()


def at_rate(job: ExportJob, rate: float) -> ExportJob:
    return replace(job, shot=replace(job.shot, frames_per_second=rate))


@given(st.floats(1, 100))
@settings(deadline=None)
def test_fingerprint_includes_frame_rate_for_exr_only(rate):
    assert fingerprint(at_rate(PICTURES, rate)) == fingerprint(PICTURES)
    assert (fingerprint(at_rate(JOB, rate)) == fingerprint()) is (rate == 24.0)


@given(st.sampled_from(["hold", "black", "stop"]), st.booleans())
@settings(deadline=None)
def test_fingerprint_ignores_options_that_affect_no_pixel(missing, force):
    shot = replace(JOB.shot, source="/elsewhere/plate.####.exr")
    other_job = replace(
        JOB, shot=shot, frames=(1001,), options=ExportOptions(missing=missing, force=force)
    )
    assert fingerprint(other_job) == fingerprint()
    assert (
        fingerprint(replace(JOB, display_settings=DisplaySettings(exposure_stops=2.0)))
        == fingerprint()
    )
    assert fingerprint(replace(PICTURES, options=ExportOptions(is_float=True))) == fingerprint(
        PICTURES
    )


def test_fingerprint_depends_on_edition_of_the_blur_unless_nothing_is_blurred(monkeypatch):
    pinhole = replace(JOB, pinhole=True)
    before = fingerprint(), fingerprint(pinhole)
    monkeypatch.setattr("heatlens.deliver.export.plan.BLUR_EDITION", 999)
    assert fingerprint() != before[0] and fingerprint(pinhole) == before[1]
