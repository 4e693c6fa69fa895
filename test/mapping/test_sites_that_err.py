"""Sites that err with tails: one slip is no inclusion, and a nodule that one site feels may be."""

import numpy as np
import pytest

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.posterior.posterior_map import read_out
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.sites import Sites

#: Of the raster; 24 is in its middle.
COUNT, MIDDLE = 7, 24


def raster(noise=0.02):
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, 0.04, COUNT)] * 2))
    k = 450.0 * (1.0 + noise * np.random.default_rng(2).standard_normal(x.size))
    return x, y, k


def sampled(x, y, k, outliers=None):
    return Sampled.of(Sites(x, y, 0 * x, None, k, 0.001 * k), outliers=outliers)


def told(x, y, k):
    found = sampled(x, y, k)
    return found, read_out(found, Sites(x, y, 0 * x, None, k, 0.001 * k))


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


def test_an_inclusion_that_one_site_feels_is_to_be_palpated_again_a_little_aside():
    x, y, k = slipped()
    _, found = told(x, y, k)
    (one,), (again,) = [each for each in found.inclusions if each.probability > 0.2], found.again
    assert one.felt_by == 1
    aside = np.hypot(again.x - x[MIDDLE], again.y - y[MIDDLE])
    assert 0.001 < aside < 0.003
    assert again.probability == one.probability
    assert any("is felt by one site: palpate again" in note for note in found.check.notes)


def test_an_inclusion_that_several_sites_feel_is_not():
    x, y, k = raster()
    k = k * (1.0 + 0.5 ** (((x - 0.02) ** 2 + (y - 0.021) ** 2) / 0.008**2))
    _, found = told(x, y, k)
    assert found.inclusions[0].probability > 0.95
    assert found.inclusions[0].felt_by > 3
    assert found.again == ()


@pytest.mark.parametrize("share", [-0.1, 1.0, np.nan])
def test_a_share_that_is_none_is_refused(share):
    with pytest.raises(ParameterError, match="a share from 0 to below 1"):
        sampled(*raster(), outliers=share)
