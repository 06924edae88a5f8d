"""What to run next.

`plan` tells before anything is recorded which effects planned runs would tell
apart; `next_run` chooses, after a diagnosis, the safe motion that separates
what it has left open. Both rest on how far apart predictions of rivals are
(`separation`) by the twin's replays of runs not yet recorded (`planned`).
"""
