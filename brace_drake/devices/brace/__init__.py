"""The whole brace, stages 1 to 3 or neighbours of them, on a torso."""
