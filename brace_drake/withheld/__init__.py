"""Diagnosis put to the test on recordings whose truth is withheld."""
