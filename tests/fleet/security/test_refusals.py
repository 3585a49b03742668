"""From Zenoh's log to events: each is told, a flood of them is not."""

from collections import Counter

from flightapp.fleet.security.refusals import SENTENCES_MAX, RefusalReport, refusals

LOG = (
    "2026 TRACE rx-0 access_control: Using cached result: abc is unauthorized to Put (ingress) on flightapp/f/e1/state\n"
    "2026 TRACE rx-0 interceptor: Msg intercepted!\n"
    "TRACE rx-0 access_control: abc on Interface(lo)+CertCommonName(p2) is unauthorized to Query (ingress) on flightapp/f/**\n"
    "2026 TRACE rx-0 interceptor: Msg intercepted!\n"
    "2026 TRACE rx-0 access_control: abc is unauthorized to Delete (ingress) on flightapp/f/p2/state\n"
    "2026 TRACE rx-0 access_control: abc is authorized to Put (ingress) on flightapp/f/p2/state\n"
    '\x1b[33m WARN\x1b[0m quic: reason: b"invalid peer certificate: UnknownIssuer" at unicast.rs\n'
    "2026 WARN acceptor failed: ConnectionClosed reason: b''\n"
)


def test_only_what_was_refused_is_counted_with_the_name_on_the_certificate() -> None:
    assert refusals(LOG, {"abc": "p2"}) == Counter(
        {
            "'p2' may not put on flightapp/f/e1/state": 1,
            "'p2' may not query on flightapp/f/**": 1,
            "a connection without a valid certificate: UnknownIssuer": 1,
        }
    )
    assert "'abc' may not put on flightapp/f/e1/state" in refusals(LOG, {})


def test_a_flood_is_a_few_events_and_invented_keys_are_a_bounded_number() -> None:
    told: list[str] = []
    report = RefusalReport(told.append)
    for _ in range(1000):
        report.add(Counter({"'p2' may not put on p1": 1}))
    assert told == [f"refused: 'p2' may not put on p1 ({count} times so far)" for count in (1, 10, 100, 1000)]
    report.add(Counter({f"key {number}": 1 for number in range(1000)}))
    assert len(told) == 4 + SENTENCES_MAX - 1
