"""The dialogs for files: a browser, and the question about a shot that was not saved."""
