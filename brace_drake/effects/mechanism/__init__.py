"""Effects of legs and ring: anchors, masses, elastic legs."""
