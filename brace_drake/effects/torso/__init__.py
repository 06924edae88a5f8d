"""Effects of the wearer's own motion."""
