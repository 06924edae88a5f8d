"""Damaged frames either way between an armed device and its host."""
