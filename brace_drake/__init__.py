"""Digital twin of a robotic scoliosis brace that says why it differs."""
