"""Boot time to fleet time by the least delayed message."""

from hypothesis import given
from hypothesis import strategies as st

from flightapp.vehicle.boot_clock import BootClock


@given(st.floats(1e9, 2e9), st.lists(st.floats(0.0, 0.3), min_size=1, max_size=200))
def test_a_datum_is_never_dated_before_it_was_true_nor_after_it_arrived(offset_s: float, delays_s: list[float]) -> None:
    clock = BootClock()
    for number, delay_s in enumerate(delays_s):
        boot_s = 0.02 * number
        arrived_s = boot_s + offset_s + delay_s
        dated_s = clock.to_fleet_s(boot_s, arrived_s)
        assert boot_s + offset_s - 1e-6 <= dated_s <= arrived_s + 1e-6


def test_the_least_delay_dates_all_later_messages() -> None:
    clock = BootClock()
    clock.to_fleet_s(0.0, 1000.001)
    assert abs(clock.to_fleet_s(1.0, 1001.2) - 1001.001) < 1e-3


def test_a_restarted_autopilot_starts_a_new_offset() -> None:
    clock = BootClock()
    clock.to_fleet_s(500.0, 1500.0)
    assert clock.to_fleet_s(0.5, 1510.0) == 1510.0


def test_a_slow_autopilot_clock_is_followed() -> None:
    clock = BootClock()
    for number in range(100_000):
        boot_s = 0.02 * number
        true_s = 1000.0 + boot_s * (1 + 5e-5)
        dated_s = clock.to_fleet_s(boot_s, true_s + 0.002)
    assert abs(dated_s - true_s) < 0.005
