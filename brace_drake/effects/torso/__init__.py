"""Effects of the subject's own motion."""
