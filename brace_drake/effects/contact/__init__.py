"""Effects of the tissue under the pads."""
