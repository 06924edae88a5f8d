"""Effects of the instruments: forces and leg lengths as they are read."""
