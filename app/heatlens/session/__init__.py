"""What the program behind the window holds and does, without a window: it draws nothing."""
