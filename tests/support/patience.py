"""How long a test waits for what must come before it gives up."""

# It bounds what a test waits for and measures nothing. A machine without the driver's cache of
# programs and with eight busy processes takes over a minute for what otherwise takes two seconds.
PATIENCE_S = 240.0
