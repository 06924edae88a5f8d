"""Tasks on threads and on a Dask cluster of two workers, one of them killed."""

import asyncio
import contextlib
import math
import os
import pickle
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import CampaignError, ClusterError
from brace_drake.core.parallel import Workers, open_workers
from brace_drake.effects.registry import find_effect
from brace_drake.laws.contact import __name__ as contact_module
from brace_drake.laws.hooks import NO_LAW
from tests.commands import run_command

try:
    from brace_drake.core.parallel.cluster import Parcel, run_parcel
except ImportError:
    Parcel = None
try:
    import distributed
except ImportError:
    distributed = None

REPOSITORY = Path(__file__).resolve().parents[1]
_NEEDS_CLUSTER = "distributed is not installed: the extra cluster"


def halve(values, shift):
    return values.sum() / 2.0 + shift


class TestThreads(unittest.TestCase):
    def test_results_come_in_the_order_of_the_tasks(self):
        told = []
        with open_workers(3) as workers:
            found = workers.map(
                lambda i: time.sleep(0.02 * (3 - i)) or i,
                [(i,) for i in range(4)],
                told.append,
            )
        self.assertEqual(found, [0, 1, 2, 3])
        self.assertEqual(told, [1, 2, 3, 4])

    def test_what_a_task_raises_is_raised(self):
        def fail(i):
            raise CampaignError(f"task {i}")

        with open_workers(2) as workers:
            with self.assertRaisesRegex(CampaignError, "task 0"):
                workers.map(fail, [(0,), (1,)])

    def test_workers_stay_what_they_are_and_travel_as_one_thread(self):
        with Workers(3) as workers:
            self.assertIs(open_workers(workers), workers)
            there = pickle.loads(pickle.dumps(workers))
            self.assertEqual(there.jobs, 1)
            there.close()


@unittest.skipIf(Parcel is None, "cloudpickle is not installed")
class TestParcels(unittest.TestCase):
    def test_compiled_functions_are_named_not_compiled_again(self):
        card = find_effect("coulomb_friction")
        law, idle = card.laws["drive"], NO_LAW["drive"]

        def is_named(one, other):
            return one is law, other is NO_LAW["drive"]

        parcel = Parcel(is_named)
        tasks = parcel.pack([(law, idle)])
        self.assertLess(len(parcel.data) + len(tasks), 4000)
        self.assertEqual(
            run_parcel(parcel.key, parcel.data, tasks), [(True, True)]
        )
        self.assertIn("brace_drake.laws", contact_module)

    def test_arrays_of_the_function_are_not_sent_again_with_its_tasks(self):
        big = np.random.default_rng(0).normal(size=20_000)

        def total(values, shift):
            values[0:0] = 0.0  # As laws need them, they can be written to.
            return big.sum() + values.sum() + shift

        parcel = Parcel(total)
        tasks = parcel.pack([(big, i) for i in range(8)])
        self.assertGreater(len(parcel.data), big.nbytes)
        self.assertLess(len(tasks), 2000)
        found = run_parcel(parcel.key, parcel.data, tasks)
        self.assertEqual(found, [2 * big.sum() + i for i in range(8)])

    def test_a_changed_array_makes_another_parcel(self):
        data = np.zeros(1000)
        keys = []
        for value in (0.0, 0.0, 1.0):
            data[5] = value
            keys.append(Parcel(lambda: data.sum()).key)
        self.assertEqual(keys[0], keys[1])
        self.assertNotEqual(keys[0], keys[2])


class Cluster:
    """A scheduler and workers on loopback, each a process."""

    def __init__(self, folder, count=2, **settings):
        self.folder = folder
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self.environment = os.environ | {
            "PYTHONPATH": str(REPOSITORY),
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONWARNINGS": "ignore",
            **settings,
        }
        self.processes = [
            self.start(
                "scheduler", "--host", "127.0.0.1", "--port", str(port),
                "--no-dashboard", "--no-jupyter",
            )
        ]  # fmt: skip
        self.workers = [self.add() for _ in range(count)]
        # A busy machine is slow to start it.
        for _ in range(1200):
            with contextlib.suppress(OSError):
                socket.create_connection(("127.0.0.1", port), 1.0).close()
                break
            time.sleep(0.1)

    def start(self, what, *words):
        command = [sys.executable, "-m", "distributed.cli.dask_" + what, *words]
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def add(self):
        process = self.start(
            "worker", self.address, "--nthreads", "1", "--no-nanny",
            "--no-dashboard", "--host", "127.0.0.1", "--local-directory",
            str(self.folder),
        )  # fmt: skip
        self.processes.append(process)
        return process

    def end(self):
        for process in self.processes:
            process.kill()
            process.wait()


@unittest.skipIf(distributed is None, _NEEDS_CLUSTER)
class TestCluster(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.cluster = Cluster(cls.folder)
        cls.addClassCleanup(cls.cluster.end)
        cls.remote = open_workers(cluster=cls.cluster.address)
        cls.addClassCleanup(cls.remote.close)
        cls.remote._client.wait_for_workers(2, timeout=120)

    def test_a_killed_worker_costs_its_tasks_alone(self):
        seen, victim = self.folder / "seen", self.cluster.workers[0].pid
        seen.mkdir()
        pause = 0.05

        def work(i):
            (seen / f"{i}-{os.getpid()}").touch()
            time.sleep(pause)
            return os.getpid(), i * i

        def kill_once(done):
            if done >= 10 and not killed:
                killed.append(done)
                os.kill(victim, signal.SIGKILL)

        def who(i):
            time.sleep(pause)
            return os.getpid()

        # On a busy machine one may begin long after the other.
        end = time.monotonic() + 120.0
        while victim not in self.remote.map(who, [(i,) for i in range(10)]):
            self.assertLess(time.monotonic(), end)
        killed = []
        found = self.remote.map(work, [(i,) for i in range(60)], kill_once)
        self.assertEqual(
            [square for _, square in found], [i * i for i in range(60)]
        )
        by = [pid for pid, _ in found]
        self.assertTrue(killed)
        self.assertIn(victim, by, "it had worked before")
        runs = len(list(seen.iterdir()))
        self.assertLessEqual(runs - 60, 4, "parts at hand when it was killed")
        self.cluster.workers[0] = self.cluster.add()
        self.remote._client.wait_for_workers(2, timeout=120)

    def test_a_notebook_whose_loop_runs_reaches_it_too(self):
        async def within():
            with open_workers(cluster=self.cluster.address) as workers:
                return workers.map(math.hypot, [(3.0, 4.0)])

        self.assertEqual(asyncio.run(within()), [5.0])

    def test_rollouts_are_the_same_bit_for_bit_wherever_they_run(self):
        from brace_drake.experiments.evaluate import draw_subjects
        from brace_drake.experiments.rollouts import Benchmark, Controller
        from brace_drake.learning.subjects import between_patients
        from tests.learning_tasks import random_policy, short_task

        task = short_task(4)
        players = [
            Controller("pic"),
            Controller("rlpic", policy=random_policy(task)),
        ]
        score = Benchmark(task).run_and_score
        tasks = [
            (p, s)
            for p in players
            for s in draw_subjects(between_patients(), 3, 0)
        ]
        with open_workers(1) as here:
            self.assertEqual(
                self.remote.map(score, tasks),
                here.map(score, tasks),
            )

    def test_an_evaluator_of_a_diagnosis_gives_the_same_residuals(self):
        from brace_drake.core.resources import example_campaign_path
        from brace_drake.devices.device import MakeDevice
        from brace_drake.identification.evaluation import Evaluator
        from brace_drake.identification.prepare import (
            estimate_floors,
            prepare_runs,
        )
        from brace_drake.identification.problem import CandidateProblem
        from brace_drake.recording import LoadCampaign

        campaign = LoadCampaign(example_campaign_path())
        twin = MakeDevice(campaign).twin
        values = np.array([p.nominal for p in twin.subject])
        floors, _ = estimate_floors(twin, campaign, values, 0)
        runs = prepare_runs(
            twin, campaign.split("fit")[:2], floors, campaign.rate_hz, 0
        )
        card = find_effect("coulomb_friction")

        def residuals(workers):
            evaluator = Evaluator(twin, runs, workers)
            strengths = np.array([0.0]), np.array([0.3])
            problem = CandidateProblem(evaluator, [card], strengths[:1])
            points = [problem.join(values, [s]) for s in strengths]
            return problem.batch(points, coarse=True)

        with open_workers(1) as one:
            here = residuals(one)
        for a, b in zip(here, residuals(self.remote), strict=True):
            np.testing.assert_array_equal(a, b)

    def test_what_a_task_raises_is_raised_here(self):
        def fail(i):
            raise CampaignError(f"task {i}")

        with self.assertRaisesRegex(CampaignError, "task 0"):
            self.remote.map(fail, [(0,)])

    def test_a_task_that_ends_all_its_workers_is_named(self):
        def end():
            os.kill(os.getpid(), signal.SIGKILL)

        # Of four workers in a row by default; one shows the same.
        once = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
        cluster = Cluster(self.folder, 1, **once)
        self.addCleanup(cluster.end)
        remote = open_workers(cluster=cluster.address)
        self.addCleanup(remote.close)
        remote._client.wait_for_workers(1, timeout=120)
        with self.assertRaisesRegex(ClusterError, "one after the other"):
            remote.map(end, [()])


class TestRefusals(unittest.TestCase):
    @unittest.skipIf(distributed is None, _NEEDS_CLUSTER)
    def test_an_address_where_nobody_answers_is_named_in_one_line(self):
        import brace_drake.core.parallel.connecting as module

        self.enterContext(mock.patch.object(module, "_REFUSED_S", 0.3))
        with tempfile.TemporaryDirectory() as out:
            status, _, errors = run_command(
                "fit", "tests/data/example", "--out", out, "--cluster",
                "tcp://127.0.0.1:9",
            )  # fmt: skip
        self.assertEqual(status, 2)
        self.assertIn("--cluster tcp://127.0.0.1:9: no Dask scheduler", errors)

    @unittest.skipIf(distributed is None, _NEEDS_CLUSTER)
    def test_an_address_that_leads_to_no_scheduler_is_refused_and_ends(self):
        for place in ("file:///etc/passwd", "inproc://x", "://"):
            with self.subTest(place=place):
                with self.assertRaisesRegex(ClusterError, "allowed: tcp, tls"):
                    open_workers(cluster=place)
        self.assertEqual(self.threads_left(), set())

    @unittest.skipIf(distributed is None, _NEEDS_CLUSTER)
    def test_who_speaks_another_language_is_no_scheduler_and_holds_nobody(self):
        import brace_drake.core.parallel.connecting as module

        self.enterContext(mock.patch.object(module, "_CONNECT_S", 1.0))
        server = self.enterContext(socket.create_server(("127.0.0.1", 0)))
        place = f"127.0.0.1:{server.getsockname()[1]}"
        for scheme in ("tcp", "tls", "ws"):
            with self.subTest(scheme=scheme):
                with self.assertRaisesRegex(ClusterError, "no Dask scheduler"):
                    open_workers(cluster=f"{scheme}://{place}")
        self.assertEqual(self.threads_left(), set())

    def threads_left(self):
        """Those of a client that would keep the process."""
        every = {thread.name for thread in threading.enumerate()}
        return {name for name in every if "IO loop" in name}

    @unittest.skipIf(distributed is None, _NEEDS_CLUSTER)
    def test_a_refused_connection_is_told_long_before_a_silent_one(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        for place in (f"tcp://127.0.0.1:{port}", "tcp://127.0.0.1:99999"):
            begun = time.monotonic()
            with self.subTest(place=place):
                with self.assertRaisesRegex(ClusterError, f"{place}: no Dask"):
                    open_workers(cluster=place)
                self.assertLess(time.monotonic() - begun, 10.0)


if __name__ == "__main__":
    unittest.main()
