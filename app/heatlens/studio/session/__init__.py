"""The program behind the window: its state and its commands, without any drawing."""
