"""The link to a physical brace: protocol, safety, firmware, host.

protocol/PROTOCOL.md is the specification. Nothing here imports drake,
torch, numba or numpy, so that a small board can run it: the standard library,
pyserial where a port is opened, PyYAML where a file of limits is read.
"""
