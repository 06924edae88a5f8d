"""Controllers of the rings: what they estimate, want, and send to the legs."""
