"""Baselines: plain methods that answer the same cases as the diagnosis.

One method in a file, each a function `answer(case) -> dict`, the answer in the
format of `brace-drake withheld score`. What they share, the fit of the subject
and the signatures of the effects, is made once for a case and kept. `run`
answers a folder of cases. No truth is read anywhere here.
"""
