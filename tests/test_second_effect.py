"""The search for two effects at once: when it ends, and what is told of it."""

import unittest
from types import SimpleNamespace
from unittest import mock

from brace_drake.document import document
from brace_drake.effects.registry import find_effect
from brace_drake.selection.search import forward as second_effect
from brace_drake.selection.search import pair_moves
from brace_drake.selection.search import screening as screen
from brace_drake.selection.search.forward import SecondEffects
from brace_drake.selection.search.pair_moves import make_simpler, set_out_afresh


class TestEnd(unittest.TestCase):
    def search(self, replays, is_settled):
        found = SecondEffects.__new__(SecondEffects)
        found._evaluator = SimpleNamespace(replays=replays)
        found._begun, found.is_cut, found._nominal = 100, False, None
        found._null = SimpleNamespace(misfit_threshold=0.1)
        found._is_settled, found._all = lambda: is_settled, list
        with mock.patch.object(second_effect, "is_near_floor", lambda *_: True):
            return found._is_done(), found.is_cut

    def test_it_is_cut_where_it_has_cost_too_much_and_found_nothing(self):
        most = 100 + second_effect._DEAR
        self.assertEqual(self.search(most + 1, False), (True, True))
        self.assertEqual(self.search(most + 1, True), (True, False))
        self.assertEqual(self.search(most, False), (False, False))
        self.assertEqual(self.search(most, True), (True, False))

    def test_what_was_cut_beside_anchors_is_no_success_and_costs_no_more(self):
        found = SecondEffects.__new__(SecondEffects)
        found._evaluator = SimpleNamespace(replays=100)
        found._begun, found.is_cut, found._stray = 100, False, None
        found._nominal = None
        found._is_settled, found._all = lambda: False, list
        found._null = SimpleNamespace(misfit_threshold=0.1)

        def lead_back(strayed, say):
            found._evaluator.replays += second_effect._DEAR + 1

        found._lead_back = lead_back
        with mock.patch.object(second_effect, "is_near_floor", lambda *_: True):
            self.assertFalse(found.try_at_rest([], lambda *_: None))
            self.assertFalse(found._is_done())
        self.assertFalse(found.is_cut)

    def test_beside_one_effect_others_are_tried_once(self):
        found = SecondEffects.__new__(SecondEffects)
        leader = SimpleNamespace(effects=("a",))
        found._evaluator = found._leader = found._nominal = None
        found._all, found._is_half = lambda: [leader], lambda fit: True
        found._is_done = lambda: False
        found._is_rough = lambda fit: False
        tried = []
        found._try_beside = lambda beside, many, say: tried.append(many)
        with (
            mock.patch.object(second_effect, "plausible", lambda fits: fits),
            mock.patch.object(second_effect, "Ground"),
        ):
            found._try_all_beside(lambda *_: None, of_many=False)
            found._try_all_beside(lambda *_: None)
        self.assertEqual(tried, [False, True])

    def test_pairs_set_out_afresh_as_long_as_they_halve_what_is_left(self):
        twin = SimpleNamespace(subject=[SimpleNamespace(nominal=5.0)])
        ground = SimpleNamespace(
            evaluator=SimpleNamespace(twin=twin),
            leader=SimpleNamespace(excess=1000.0),
        )
        for left, steps in (
            ([900.0], 1),
            ([400.0, 300.0], 2),
            ([400.0, 100.0, 20.0], 3),
            ([400.0, 1.0], 2),
        ):
            rest = iter([1000.0, *left])
            runner = SimpleNamespace(
                excess=1000.0,
                fit=lambda rest=rest: SimpleNamespace(
                    name="a+b", excess=next(rest)
                ),
            )
            with (
                mock.patch.object(
                    pair_moves, "line_up_pair", return_value=runner
                ) as line_up,
                mock.patch.object(
                    pair_moves, "step", return_value=True
                ) as step,
            ):
                kept = set_out_afresh(
                    ground, (0.0, "a", "b"), 2.0, lambda *_: None
                )
            self.assertEqual(line_up.call_args.args[3].tolist(), [5.0])
            self.assertEqual(step.call_count, steps)
            self.assertEqual(kept, [runner])

    def test_a_pair_sets_out_at_the_strengths_that_leave_least(self):
        ground = SimpleNamespace(
            evaluator=SimpleNamespace(twin=SimpleNamespace(subject=[])),
            leader=SimpleNamespace(excess=1.0),
        )
        rests = {(1.0, 1.0): 9.0, (1.0, 0.5): 4.0, (0.5, 0.5): 7.0}

        def line_up(ground, first, second, subject, strengths):
            rest = rests.get(strengths)
            return rest and SimpleNamespace(
                excess=rest, fit=lambda: SimpleNamespace(name="", excess=rest)
            )

        with (
            mock.patch.object(pair_moves, "line_up_pair", line_up),
            mock.patch.object(pair_moves, "step", return_value=True),
        ):
            (kept,) = set_out_afresh(
                ground, (0.0, "a", "b"), 2.0, lambda *_: None
            )
        self.assertEqual(kept.excess, 4.0)

    def test_a_special_case_is_tried_with_the_values_of_the_general_one(self):
        # Stribeck friction without its bump is Coulomb friction.
        cards = [
            find_effect(key)
            for key in (
                "coulomb_friction",
                "coulomb_friction (without creep)",
                "force_gain",
            )
        ]
        rich = find_effect("stribeck_friction (without creep)")
        zone = find_effect("force_deadzone")
        pair = SimpleNamespace(
            uses=((zone, [0.05]), (rich, [0.07, 0.0, 0.002])),
            subject="subject",
            spread=None,
        )
        with mock.patch.object(pair_moves, "make_runner", lambda *given: given):
            made = list(make_simpler("ground", pair, cards))
        ((ground, effects, values, subject, spread),) = made
        self.assertEqual(ground, "ground")
        self.assertEqual(effects, (zone, cards[1]))
        self.assertEqual([list(v) for v in values], [[0.05], [0.07]])
        self.assertEqual((subject, spread), ("subject", None))

    def test_a_promise_of_few_or_of_a_breath_is_half_of_what_a_search_takes(
        self,
    ):
        promises = {
            "force_bias": 1.9,
            "breathing": 1.9,
            "ring_mass": 2.1,
            "anchor_error": 1.1,
            "encoder_offset": 0.9,
        }
        cards = [find_effect(name) for name in promises]
        leader = SimpleNamespace(effects=())
        ground = SimpleNamespace(is_exact=False, leader=leader)
        with (
            mock.patch.object(
                screen,
                "line_up",
                lambda _, card: [
                    SimpleNamespace(card=card, promise=promises[card.name])
                ],
            ),
            mock.patch.object(screen, "search_best") as search,
        ):
            screen.race(ground, cards, bar=1.0)
        names = [runner.card.name for runner in search.call_args.args[1]]
        self.assertEqual(names, ["encoder_offset", "force_bias", "breathing"])

    def test_a_diagnosis_says_so(self):
        for is_cut in (True, False):
            found = SimpleNamespace(
                campaign=SimpleNamespace(
                    warnings=[], runs=[SimpleNamespace(repeat_of="push.csv")]
                ),
                device=SimpleNamespace(rungs=[]),
                evaluator=None,
                ladder=[],
                floor_ratios={},
                validation_runs=[None],
                verdict=SimpleNamespace(winner=None),
                table=SimpleNamespace(parameters=[]),
                is_cut=is_cut,
            )
            told = document._warnings(found)
            self.assertEqual(
                ["were not tried" in w for w in told], [True] * is_cut
            )
