"""Sites that err with tails: one slip is no inclusion, and a nodule that one site feels may be."""

import numpy as np
import pytest

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.posterior.sampled import Sampled
from tissue_probe.mapping.sites import Sites

#: Of the raster; 24 is in its middle.
COUNT, MIDDLE = 7, 24


def raster(noise=0.02):
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, 0.04, COUNT)] * 2))
    k = 450.0 * (1.0 + noise * np.random.default_rng(2).standard_normal(x.size))
    return x, y, k


def sampled(x, y, k, **named):
    return Sampled.of(Sites(x, y, 0 * x, None, k, 0.001 * k), **named)


def surest(found):
    return max((one.probability for one in found.found), default=0.0)


def slipped():
    x, y, k = raster()
    k[MIDDLE] *= 2.0
    return x, y, k


def test_a_site_that_alone_is_stiff_is_no_sure_inclusion():
    found = sampled(*slipped())
    assert surest(found) < 0.9
    assert (found.states.kinds > 0).mean(axis=(0, 1)).argmax() == MIDDLE


def test_where_contact_was_verified_it_is_one():
    assert surest(sampled(*slipped(), outliers=0.0)) > 0.9


def test_a_second_visit_tells_a_slip_from_a_nodule():
    x, y, k = slipped()
    for felt, sure in ((1.0, False), (2.0, True)):
        again = (np.append(each, each[MIDDLE]) for each in (x, y))
        found = sampled(*again, np.append(k, 450.0 * felt))
        assert (surest(found) > 0.9) == sure


@pytest.mark.parametrize("share", [-0.1, 1.0, np.nan])
def test_a_share_that_is_none_is_refused(share):
    with pytest.raises(ParameterError, match="a share from 0 to below 1"):
        sampled(*raster(), outliers=share)
