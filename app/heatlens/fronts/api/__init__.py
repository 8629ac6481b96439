"""heatlens from Python: open a plate or a scene, look at it through a lens, get an array.

    import heatlens

    with heatlens.open("plate.exr") as plate:
        for f_stop in (1.4, 2.8, 5.6):
            picture = plate.render(f_stop=f_stop, focus_at=(290, 190))

    heatlens.open(color, depth_m).render(f_stop=2, focus_distance_m=3, focal_length_mm=50)
    heatlens.open("shot.heatlens.json").render(frame=1012)
    for frame in heatlens.open("shot.####.exr"):
        print(frame.number, frame.size, frame.depth_range_m, frame.lens, frame.behind)
        picture = frame.render(f_stop=2, focus_distance_m=3)
    heatlens.open("scene.glb", size=(960, 540)).render(f_stop=2, focus_distance_m=3, views=256,
                                                       method="accumulation")

Doubtful input is reported as a `HeatlensWarning`; `Source.notes` says how the source was read.

The commands use the same functions: `FrameRenderer` draws, `plate_lens` and `first_shot` find the
lens. The GPU is opened with the first picture and stays with that thread. With OpenGL, `render`
leaves its context current; other code that draws in that thread must make its own current again.
"""

from heatlens.fronts.api.frame import Frame
from heatlens.fronts.api.opening import open
from heatlens.fronts.api.source import Source

__all__ = ["Frame", "Source", "open"]
