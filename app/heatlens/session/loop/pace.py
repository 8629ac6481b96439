"""How much is drawn between two looks for input, from the time that it took before."""

# Longest time from one look for input to the next, and a time far below it.
MOST_S, QUICK_S = 0.03, 0.008
LEAST = 1 / 16  # of what is drawn at once where there is time enough
_IN_A_ROW = 2  # slow steps: a single one may have built a program
_QUICK_IN_A_ROW = 32  # quick ones, after which twice as much is tried


class Pace:
    """The share of a usual step that fits between two looks for input."""

    def __init__(self) -> None:
        self.share = 1.0
        self._slow = self._quick = 0

    def took(self, seconds: float) -> None:
        """Take in the time of a step: slow ones halve the share, many quick ones double it."""
        self._slow = self._slow + 1 if seconds > MOST_S else 0
        self._quick = self._quick + 1 if seconds < QUICK_S else 0
        if self._slow == _IN_A_ROW:
            self.share, self._slow = max(LEAST, self.share / 2), 0
        elif self._quick == _QUICK_IN_A_ROW:
            self.share, self._quick = min(1.0, self.share * 2), 0
