"""Diagnoses over time: has the machine or the subject changed?

`sessions` reads diagnoses and their dates, `diagnosed` makes those that are
missing and keeps them, `grouping` holds that one trend is of one machine.
`statistics` tests numbers with intervals, `presence` tests verdicts, `alarms`
shares one false-alarm level out over all tests. `document` writes it all down
as trend.json; `page` and `table` show that.
"""
