"""The serial link between a host and a brace, in five rooms.

`protocol` has the messages and their bytes (PROTOCOL.md there is the
specification), `device` what a firmware does each tick and the safety
supervisor, `host` the port and the conversation on it, `emulator` a device in
software, `operation` what a host does with a device: recording, deploying, a
twin beside it.

The first three import neither drake, torch, numba nor numpy, so that a small
board can run them: the standard library, pyserial where a port is opened,
PyYAML where a file of limits is read.
"""
