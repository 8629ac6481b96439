"""What stands before the lens, and the picture of it that follows the hand."""
