"""Searches side by side against the same ones alone."""

import unittest

from brace_drake.core.parallel.together import ask, together


class TestTogether(unittest.TestCase):
    def setUp(self):
        self.asked = []

    def answer(self, questions):
        self.asked.append(list(questions))
        return [q * q for q in questions]

    def search(self, start, rounds):
        total = start
        for _ in range(rounds):
            total += ask(total, self.answer)
        return total

    def test_a_search_alone_is_answered_at_once(self):
        self.assertEqual(self.search(2, 2), 2 + 4 + 36)
        self.assertEqual(self.asked, [[2], [6]])

    def test_questions_of_searches_come_together(self):
        found = together(
            [lambda: self.search(2, 2), lambda: self.search(3, 1), lambda: 5],
            self.answer,
        )
        self.assertEqual(found, [42, 12, 5])
        self.assertEqual(self.asked, [[2, 3], [6]])

    def test_searches_within_one_follow_each_other(self):
        def outer(start):
            return together(
                [lambda: self.search(start, 1), lambda: self.search(9, 1)],
                self.answer,
            )

        found = together([lambda: outer(1), lambda: outer(2)], self.answer)
        self.assertEqual(found, [[2, 90], [6, 90]])
        self.assertEqual(self.asked, [[1, 2], [9, 9]])

    def test_what_a_search_raises_is_raised(self):
        def fails():
            ask(1, self.answer)
            raise KeyError("lost")

        with self.assertRaisesRegex(KeyError, "lost"):
            together([fails, lambda: self.search(2, 3)], self.answer)

    def test_an_error_of_the_answer_is_raised(self):
        def no_answer(questions):
            raise ValueError("no answer")

        with self.assertRaisesRegex(ValueError, "no answer"):
            together([lambda: ask(1, no_answer)], no_answer)

    def test_no_search_needs_no_answer(self):
        self.assertEqual(together([], self.answer), [])
        self.assertEqual(self.asked, [])


if __name__ == "__main__":
    unittest.main()
