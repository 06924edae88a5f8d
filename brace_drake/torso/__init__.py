"""The torso: its surface, its solid, and its contact with the brace's pads."""
