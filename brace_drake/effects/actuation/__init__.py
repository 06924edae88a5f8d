"""Effects of the drives: friction, play, dead time, gains and limits."""
