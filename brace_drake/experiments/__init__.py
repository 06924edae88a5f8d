"""The paper's experiments: controllers compared, the twin validated."""
