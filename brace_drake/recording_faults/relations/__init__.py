"""What recorded channels say of each other by a declared law."""
