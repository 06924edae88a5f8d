"""An emulated brace on a pseudo-terminal, with the bench's own laws."""
