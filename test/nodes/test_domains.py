"""Workers that test side by side have no DDS domain in common."""

from __future__ import annotations

import pytest

from domains import domains_of


@pytest.mark.parametrize("workers", [1, 2, 3, 4, 7, 16])
def test_each_domain_is_one_workers_own_and_none_has_ports_that_the_system_hands_out(workers):
    shares = [domains_of(worker, workers) for worker in range(workers)]
    dealt = [domain for share in shares for domain in share]
    assert len(dealt) == len(set(dealt))
    # What a test leaves behind dies before its domain comes round again.
    assert min(map(len, shares)) >= 6
    # The last port of a domain's hundred participants, by DDSI-RTPS 9.6.1.
    assert all(0 < 7400 + 250 * domain + 11 + 2 * 100 < 32768 for domain in dealt)
