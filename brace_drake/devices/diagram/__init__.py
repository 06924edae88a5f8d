"""Any machine that a Drake diagram models.

`factory` finds the function that makes the diagram, `model` runs it, `rollout`
replays a recording with effects at its ports, joints and bodies.
"""
