"""Diagnosis put to the test on recordings whose truth is withheld.

`make_cases` draws subjects and faults and records them on an independent
simulator of the bench; their truth is sealed. `answer_cases` has each diagnosed
by the command line as a user would, and commits to the answers. `load_judged`
checks seals and commitment, `score` says how often the answers were right.
Nothing here knows the twin.
"""
