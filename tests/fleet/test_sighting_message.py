from __future__ import annotations

import pytest

from flightapp.fleet.messages.codec import Header, decode, encode
from flightapp.fleet.messages.sighting import SIGHTING, Sighting, as_heard


def test_all_vehicles_filter_the_same_numbers_the_one_that_saw_included() -> None:
    seen = Sighting(99.93412, 12.34567, -5.4321, -2.98765, 0.41239, 0.0012)
    payload = encode(SIGHTING, seen, Header("p1", 7, 100.0))
    heard, _ = decode(SIGHTING, payload)
    assert heard == as_heard(seen, 100.0)
    assert heard.north_m == pytest.approx(seen.north_m, abs=0.005)
    assert heard.t_s == pytest.approx(seen.t_s, abs=0.0005)
    assert heard.across_sigma_m == 0.01
    assert len(payload) < 40
