"""The command line: one module for a command, in a folder for its group.

A module of a group that has `AddParser` is a command. It reads options, calls
the package and prints; nothing is decided here.
"""
