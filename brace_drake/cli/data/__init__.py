"""Commands about recordings and the machine: check, import, doctor."""
