"""LeafSystems of the twin; each declares ports and state around a law."""
