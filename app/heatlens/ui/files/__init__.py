"""What is opened, saved, copied and remembered."""
