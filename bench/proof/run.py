"""Prove many cases: a map over jobs, on this machine's processes or on a Dask cluster, with the same results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bench.errors import ProofError
from bench.processes import over, workers
from bench.proof import make
from bench.proof.analyse import Job, Outcome, done_before, draw_case, prove_case
from bench.proof.score import CaseScore, score
from bench.proof.through.case import GROUP

#: Campaigns through the bench where no number is given.
THROUGH = 20
#: Sets of folders without effect.
NULLS = ("null", "null_small")
Progress = Callable[[int, int, CaseScore], None]


@dataclass(frozen=True, slots=True)
class Plan:
    """Which cases to prove.

    Attributes:
        groups: names of the examiner's groups. count: at most so many of each, None for all.
        nulls: number of folders without effect, None for the group's own number.
        held_back: draw from the forms nobody tunes on. clutter: give every gearbox weak orders.
        again: of cases through the bench, ask another campaign whether the model holds.
    """

    groups: tuple[str, ...]
    seed: int = 1
    count: int | None = None
    nulls: int | None = None
    held_back: bool = False
    clutter: bool = False
    again: bool = False


def jobs_of(plan: Plan, out: Path, keep: bool) -> list[Job]:
    """The jobs of a plan, in the groups' order."""
    if plan.groups == (GROUP,):
        names = [f"{GROUP}-{number:03d}" for number in range(plan.count or THROUGH)]
        return [Job(GROUP, name, plan.seed, False, out, keep=keep, again=plan.again) for name in names]
    examiner = make.load_examiner()
    picked = []
    for group in plan.groups:
        count = plan.nulls if group in NULLS and plan.nulls is not None else plan.count
        listed = make.list_cases(examiner, [group], plan.seed, count, plan.held_back, plan.clutter)
        picked += [(group, case.name) for case in listed]
    return [Job(group, name, plan.seed, plan.held_back, out, keep=keep, clutter=plan.clutter) for group, name in picked]


def prove(
    jobs: Sequence[Job], processes: int = 1, dask: str | None = None, progress: Progress | None = None
) -> list[CaseScore]:
    """Prove all jobs and return their scores in the jobs' order."""
    scores: dict[int, CaseScore] = {}
    for index, outcome in _outcomes(jobs, processes, dask):
        scores[index] = score(outcome.truth, outcome.report, outcome.seconds, outcome.failed, outcome.recomputed)
        if progress is not None:
            progress(len(scores), len(jobs), scores[index])
    return [scores[index] for index in sorted(scores)]


def done_so_far(jobs: Sequence[Job]) -> list[CaseScore]:
    """Scores of the jobs that are done, in the jobs' order; nothing is made or analysed."""
    outcomes = (done_before(job) for job in jobs)
    return [score(o.truth, o.report, o.seconds, o.failed, o.recomputed) for o in outcomes if o is not None]


def make_only(jobs: Sequence[Job], processes: int = 1) -> list[Path]:
    """Make the folders and seal the truths without analysing anything."""
    return list(over(_make, jobs, processes))


def sweep_jobs(jobs: Iterable[Job], strengths: Sequence[float]) -> list[Job]:
    """Every job at every strength (in units of the noise floor)."""
    return [
        replace(job, strength=value, label=f"{job.name}-s{job.seed}-x{value:.3g}")
        for job in jobs
        for value in strengths
    ]


def _make(job: Job) -> Path:
    examiner = make.load_examiner()
    return make.make_case(examiner, draw_case(examiner, job), job.out)


def _outcomes(jobs: Sequence[Job], processes: int, dask: str | None) -> Iterator[tuple[int, Outcome]]:
    if dask is not None:
        yield from _on_dask(jobs, dask)
    elif processes <= 1:
        yield from ((index, prove_case(job)) for index, job in enumerate(jobs))
    else:
        with workers(processes) as pool:
            waiting = {pool.submit(prove_case, job): index for index, job in enumerate(jobs)}
            for future in as_completed(waiting):
                yield waiting[future], future.result()


def _on_dask(jobs: Sequence[Job], address: str) -> Iterator[tuple[int, Outcome]]:
    """The same map on an existing cluster whose workers have this package; they need not share our disk."""
    try:
        import distributed
    except ImportError as error:
        raise ProofError("--dask needs the package distributed: install the optional dependencies 'dask'.") from error
    client: Any
    with distributed.Client(address) as client:
        waiting = {client.submit(prove_case, job, pure=False): index for index, job in enumerate(jobs)}
        for future in distributed.as_completed(waiting):
            yield waiting[future], future.result()
