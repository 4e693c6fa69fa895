"""The wall clock steps while real nodes run: an NTP correction, a hand on the clock."""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray

from conftest import SCAN, STAGE, Scanning, collect, driver, estimator, goal
from tissue_probe.nodes.conversions import from_time
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.bags.reader import read_estimates, read_recording
from tissue_probe.signals import NANOSECONDS, join
from tissue_probe_msgs.msg import PalpationSite

HOUR = 3600

#: What every process of a test has in place of the C library's clock: that of the kernel, moved by
#: as many seconds as a file says, in this instant. The kernel's own would step for all the machine.
#: What the wheels' DDS waits for by the wall clock comes after as long as it asked for, as in a DDS
#: that was built with a younger C library, which waits by the monotonic clock.
CLOCK = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static const volatile long long *ahead;
static int (*of_libc)(clockid_t, struct timespec *); /* a system call costs ten times as much */

__attribute__((constructor)) static void begin(void) {
    of_libc = dlsym(RTLD_NEXT, "clock_gettime");
    int file = open(getenv("CLOCK_AHEAD"), O_RDONLY);
    ahead = mmap(0, sizeof *ahead, PROT_READ, MAP_SHARED, file, 0);
}

int clock_gettime(clockid_t clock, struct timespec *now) {
    int failed = of_libc ? of_libc(clock, now) : syscall(SYS_clock_gettime, clock, now);
    if (!failed && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) && ahead)
        now->tv_sec += *ahead;
    return failed;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    struct timespec exact;
    clock_gettime(CLOCK_REALTIME, &exact);
    now->tv_sec = exact.tv_sec;
    now->tv_usec = exact.tv_nsec / 1000;
    return 0;
}

int pthread_cond_timedwait(
    pthread_cond_t *condition, pthread_mutex_t *mutex, const struct timespec *until) {
    static int (*wait)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
    if (!wait)
        wait = dlvsym(RTLD_NEXT, "pthread_cond_timedwait", "GLIBC_2.3.2");
    struct timespec of_kernel = *until;
    if (!(condition->__data.__wrefs & 2)) { /* not by the monotonic clock */
        of_kernel.tv_sec -= *ahead;
        /* Steps are of whole hours, waits are shorter: `until` may be of the time before a step. */
        struct timespec now;
        of_libc(CLOCK_REALTIME, &now);
        of_kernel.tv_sec -= 3600 * lround((of_kernel.tv_sec - now.tv_sec) / 3600.0);
    }
    return wait(condition, mutex, &of_kernel);
}

time_t time(time_t *told) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (told)
        *told = now.tv_sec;
    return now.tv_sec;
}
"""


@pytest.fixture
def set_clock(tmp_path, cold, monkeypatch) -> Callable[[int], None]:
    """Set the wall clock of every process that is started from now on: seconds ahead of ours."""
    ahead, library = tmp_path / "ahead", tmp_path / "clock.so"
    ahead.write_bytes(struct.pack("q", 0))
    subprocess.run(
        ["gcc", "-shared", "-fPIC", "-x", "c", "-o", library, "-", "-lm"],
        input=CLOCK, text=True, check=True,
    )  # fmt: skip
    monkeypatch.setenv("CLOCK_AHEAD", str(ahead))
    monkeypatch.setenv("LD_PRELOAD", str(library))

    def step(seconds: int) -> None:
        with ahead.open("r+b") as file:
            file.write(struct.pack("q", seconds))

    return step


@pytest.mark.crowded
@pytest.mark.slow
def test_a_scan_goes_on_as_if_the_wall_clock_had_not_stepped(session, set_clock, bag):
    filters = [estimator("robust_ekf")]
    recorder = NodeProcess("recorder", "recorder", parameters={"output": str(bag)})
    # It hears no filter, so that no dwell ends before the clock has stepped in it.
    scan = replace(SCAN, parameters={**SCAN.parameters, "estimators": ["ekf"]})
    running = session(driver(), STAGE, scan, *filters, recorder)
    health = collect(running.node, DiagnosticArray, "/diagnostics")
    running.activate(
        {"/probe/driver": 3, "/probe/scan": 2, "/probe/robust_ekf": 1}, {"/probe/robust_ekf": 2}
    )

    def wait_for_clocks(ahead: int) -> None:
        """Wait until every node has told its health by a clock that is so many seconds ahead."""
        health.clear()
        named = ("driver", "scan", "robust_ekf", "recorder", "stage")

        def told() -> bool:
            now = running.node.get_clock().now().nanoseconds
            heard = {
                status.name.rpartition("/")[2]
                for array in health
                if abs(from_time(array.header.stamp) - now - ahead * NANOSECONDS)
                < 600 * NANOSECONDS
                for status in array.status
            }
            return heard.issuperset(named)

        running.wait_until(told, f"the nodes' health, {ahead} s ahead")

    wait_for_clocks(0)
    scanning = Scanning(running, goal(columns=2, dwell_time=4.0))
    scanning.wait_for(PalpationSite.DWELL)
    set_clock(HOUR)
    wait_for_clocks(HOUR)
    set_clock(-HOUR)
    wait_for_clocks(-HOUR)
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.deactivate()
    assert all(process.poll() is None for process in running.processes.values())
    said = running.health["/probe/robust_ekf"]
    assert (said["samples lost"], said["messages malformed"]) == ("0", "0")
    running.wait_until(lambda: len(read_recording(bag).sites) == 6, "the last announcement")
    running.__exit__()
    recording = read_recording(bag)
    (samples,) = join(recording.blocks)  # one run, in which nothing is missing, begun once
    assert samples.sequence == 0
    assert len(samples) > 8.0 / samples.sample_period
    assert all(samples.stamp < site.stamp < samples.end for site in recording.sites)
    for (_, dwell), (_, lifted) in zip(phases(recording, 1), phases(recording, 2), strict=True):
        assert 4.0 <= (lifted - dwell) / NANOSECONDS < 10.0
    (estimates,) = read_estimates(bag).values()
    np.testing.assert_array_equal(estimates.stamp, samples.stamps[estimates.sequence])
    assert (np.diff(estimates.sequence) == 10).all()


def phases(recording, phase: int) -> list[tuple[int, int]]:
    return [(site.site, site.stamp) for site in recording.sites if site.phase == phase]
