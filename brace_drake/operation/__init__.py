"""Working with a device: recording, deploying, a twin beside it."""
