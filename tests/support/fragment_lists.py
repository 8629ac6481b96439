"""Make fragment lists (deep samples) from plain arrays."""

from heatlens.media.plate.fragments import FragmentLists, pack_starts, pack_words


def packed_lists(counts, has_front, rgba, depth_m, is_measured=False):
    """Pack the fragments of all pixels, each pixel's near to far.

    `counts` and `has_front` are (H * W,); `rgba` (N, 4), straight colour and coverage, and
    `depth_m` (N,) hold the fragments of one pixel after those of the pixel before.
    """
    return FragmentLists(pack_starts(counts, has_front), pack_words(rgba, depth_m), is_measured)
