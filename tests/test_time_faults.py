"""Sizes of delays and of clocks, refined."""

import unittest

from brace_drake.recording_faults.relations.time_faults import (
    CLOCKS,
    delays,
    size_text,
)

PERIOD = 0.005


class TestRefined(unittest.TestCase):
    def refined(self, fault, truth, parts=1.0):
        """From the best of the grid, as a misfit with its least at truth has
        it, and how often that was asked.
        """
        asked = []

        def look(size):
            asked.append(size)
            return size

        def left(size):
            return abs(size - truth)

        start = min(fault.signed(), key=left)
        size = fault.refined(start, start, look, left, parts)
        self.assertEqual(len(asked), len(set(asked)))
        return size

    def test_every_delay_is_found_to_the_sample(self):
        fault = delays(PERIOD, (1, 2, 3, 5, 8, 13, 21, 34))
        for samples in (1, 4, 6, 7, 11, 15, 27, 40, 60):
            for sign in (1.0, -1.0):
                truth = sign * samples * PERIOD
                with self.subTest(samples=sign * samples):
                    found = self.refined(fault, truth)
                    self.assertAlmostEqual(found, truth, delta=1e-9)

    def test_parts_of_a_sample_are_found_where_they_are_asked(self):
        fault = delays(PERIOD, (1, 3, 8))
        found = self.refined(fault, 4.37 * PERIOD, parts=100.0)
        self.assertAlmostEqual(found, 4.37 * PERIOD, delta=0.011 * PERIOD)

    def test_every_clock_is_found_to_its_finest_step(self):
        for rate in (0.0007, 0.0042, 0.0065, 0.02, -0.011, -0.0018):
            with self.subTest(rate=rate):
                found = self.refined(CLOCKS, rate)
                self.assertAlmostEqual(found, rate, delta=1.01e-4)

    def test_no_size_leaves_what_is_likely(self):
        self.assertLess(abs(self.refined(CLOCKS, -5.0)), 0.07)


class TestText(unittest.TestCase):
    def test_either_sign_is_told_in_words(self):
        for values, text in (
            ({"delay_s": 0.02}, "20 ms late; "),
            ({"delay_s": -0.005}, "5 ms early; "),
            ({"rate": 0.01}, "1 % ahead of the others; "),
            ({"rate": -0.004}, "0.4 % behind the others; "),
            ({"scale": 2.0}, ""),
        ):
            self.assertEqual(size_text(values), text)


if __name__ == "__main__":
    unittest.main()
