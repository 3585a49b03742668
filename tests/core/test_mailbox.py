from __future__ import annotations

import math
import threading

from flightapp.core.mailbox import Latest


def test_the_newest_value_wins_and_carries_its_arrival() -> None:
    slot: Latest[str] = Latest()
    assert slot.get() is None
    assert slot.age_s(5.0) == math.inf
    slot.put("first", 1.0)
    slot.put("second", 2.0)
    item = slot.get()
    assert item is not None
    assert (item.value, item.arrived_s) == ("second", 2.0)
    assert slot.received == 2
    assert slot.age_s(5.0) == 3.0


def test_a_reader_never_sees_a_value_with_the_stamp_of_another() -> None:
    slot: Latest[int] = Latest()
    torn: list[int] = []
    done = threading.Event()

    def read() -> None:
        while not done.is_set():
            item = slot.get()
            if item is not None and item.value != item.arrived_s:
                torn.append(item.value)

    reader = threading.Thread(target=read)
    reader.start()
    for number in range(20_000):
        slot.put(number, float(number))
    done.set()
    reader.join()
    assert torn == []
