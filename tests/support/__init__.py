"""What the tests share: small files, plates, scenes, windows and oracles."""
