"""Rollouts of a part of a brace alone: a leg, a pad, and the axis of any
machine of one joint.
"""
