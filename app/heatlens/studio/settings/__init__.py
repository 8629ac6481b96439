"""What sessions and front ends share: preferences, the command line, exports and files."""
