"""The terminal view: a table, the target, a map, alarms and events; commands by key, sent at the second press.

    q quit    up/down select    h hold  r return  l land  u resume  a abort    escape cancel

It shows what `look` gives and hands what was confirmed to `send`; it knows neither network nor files.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from datetime import UTC, datetime

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.events import Resize
from textual.widgets import DataTable, Static

from flightapp.config.mission import Mission
from flightapp.core.clock import Clock
from flightapp.fleet.operator import Answer
from flightapp.watch.data_model_alarms import Level
from flightapp.watch.data_model_canvas import Ink
from flightapp.watch.data_model_confirmation import Confirmation, Order
from flightapp.watch.data_model_fleet import Overview
from flightapp.watch.data_model_map import draw_map
from flightapp.watch.data_model_thresholds import Thresholds
from flightapp.watch.frontend_cells import HEADINGS, LEADS, WIDTHS, Cell, Look, cells_of, leader_text, target_text

REFRESH_PERIOD_S = 0.2
MAP_COLUMNS_MIN = 20
"""A narrower map is left out, and its room given to the alarms."""
NARROW_COLUMNS = 60
ALL = "all"
"""Key of the table's first row: the whole fleet."""
KEYS = {"h": "hold", "r": "rtl", "l": "land", "u": "resume", "a": "abort"}
HELP = "↑↓ select  h hold r return l land u resume a abort: twice  esc cancel  q quit"
LOOKS = {
    Look.PLAIN: "",
    Look.GOOD: "green",
    Look.WARNING: "yellow",
    Look.BAD: "bold red",
    Look.FAINT: "dim",
}
INKS = {
    Ink.NOTHING: "",
    Ink.FENCE: "dim",
    Ink.OBSTACLE: "green",
    Ink.BOUNDARY: "bold yellow",
    Ink.GOAL: "cyan",
    Ink.PURSUER: "bold bright_blue",
    Ink.EVADER: "bold bright_red",
    Ink.LOST: "bold reverse red",
}

Send = Callable[[Order, Callable[[Answer], None]], Awaitable[str]]


@dataclass(frozen=True, slots=True)
class Source:
    """What the view is of. `endpoints`: to tell where it listens while nobody is heard."""

    mission: Mission
    endpoints: tuple[str, ...]
    thresholds: Thresholds
    look: Callable[[], Overview]
    send: Send


class WatchApp(App[None]):
    """One terminal."""

    ENABLE_COMMAND_PALETTE = False
    CSS = """
    #title, #help { height: 1; }
    #target { height: auto; max-height: 2; }
    #title { background: $primary-darken-2; text-style: bold; }
    #fleet { height: auto; max-height: 45%; }
    #lower { height: 1fr; }
    #map { width: 45%; height: 1fr; }
    #news { width: 1fr; height: 1fr; padding-left: 1; }
    #alarms { height: auto; max-height: 60%; }
    #events { height: 1fr; }
    #order { height: auto; max-height: 5; background: $surface; }
    #help { color: $text-muted; }
    .narrow #map { display: none; }
    """
    BINDINGS = [
        Binding("q,ctrl+c", "quit", "quit", priority=True),
        Binding("escape", "cancel", "cancel"),
        *(Binding(key, f"order('{action}')", action) for key, action in KEYS.items()),
    ]

    def __init__(self, source: Source, clock: Clock) -> None:
        super().__init__()
        self._source, self._clock = source, clock
        self._confirmation = Confirmation()
        self._began_s = clock.now_s()
        self._answers: dict[str, str] = {}
        self._order_sent: Order | None = None
        self._note = ""
        self._sending: set[asyncio.Task[None]] = set()
        self._shown: dict[tuple[str, str], Cell] = {}

    async def all_sent(self) -> None:
        """Until whatever was confirmed is answered or given up: quitting does not take a command back."""
        await asyncio.gather(*self._sending)

    def compose(self) -> ComposeResult:
        yield Static(id="title", markup=False)
        yield DataTable(id="fleet", cursor_type="row", cell_padding=0)
        yield Static(id="target", markup=False)
        with Horizontal(id="lower"):
            yield Static(id="map", markup=False)
            with Vertical(id="news"):
                yield Static(id="alarms", markup=False)
                yield Static(id="events", markup=False)
        yield Static(id="order", markup=False)
        yield Static(HELP, id="help", markup=False)

    def on_mount(self) -> None:
        self.title = f"flightapp watch {self._source.mission.name}"
        table = self._table()
        names = [vehicle.name for vehicle in self._source.mission.vehicles]
        name_width = max(map(len, (*names, ALL))) + len(LEADS) + 1
        for heading, width in zip(HEADINGS, (name_width, *WIDTHS), strict=True):
            table.add_column(heading, key=heading, width=width)
        table.add_row(ALL, *[""] * (len(HEADINGS) - 1), key=ALL)
        for name in names:
            table.add_row(name, *[""] * (len(HEADINGS) - 1), key=name)
        table.focus()
        self.refresh_view()
        self.set_interval(REFRESH_PERIOD_S, self.refresh_view)

    def on_resize(self, event: Resize) -> None:
        self.screen.set_class(event.size.width < NARROW_COLUMNS, "narrow")

    def refresh_view(self) -> None:
        """Look, and show what is seen."""
        if not self._is_open():
            return
        overview = self._source.look()
        self._show_title(overview)
        self._show_rows(overview)
        self.query_one("#target", Static).update(target_text(overview))
        self._show_map(overview)
        self.query_one("#alarms", Static).update(_alarms_text(overview))
        self.query_one("#events", Static).update(_events_text(overview))
        self._show_order()

    def action_order(self, action: str) -> None:
        """A command's key was pressed."""
        order = Order(action, self._selected())
        if self._confirmation.press(order, self._clock.now_s()):
            self._order_sent, self._note = order, ""
            self._answers = dict.fromkeys(order.vehicles, "...")
            task = asyncio.create_task(self._send(order))
            self._sending.add(task)
            task.add_done_callback(self._sending.discard)
        self._show_order()

    def action_cancel(self) -> None:
        self._confirmation.cancel()
        self._show_order()

    def on_data_table_row_highlighted(self) -> None:
        """A confirmation is for the vehicles that were selected when it was asked for."""
        self._confirmation.cancel()

    def _selected(self) -> tuple[str, ...]:
        table = self._table()
        key = table.coordinate_to_cell_key(table.cursor_coordinate).row_key.value
        return tuple(vehicle.name for vehicle in self._source.mission.vehicles if key in (ALL, vehicle.name))

    async def _send(self, order: Order) -> None:
        def show(answer: Answer) -> None:
            if order is self._order_sent:
                self._answers[answer.vehicle] = _answer_text(answer)

        self._note = await self._source.send(order, show)
        if self._is_open():
            self._show_order()

    def _is_open(self) -> bool:
        """Not so once the person has quit, while the last period and the last command still run."""
        return bool(self.query("#help"))

    def _table(self) -> DataTable[Text | str]:
        return self.query_one("#fleet", DataTable)

    def _show_title(self, overview: Overview) -> None:
        source = self._source
        if overview.is_heard:
            here = f"{source.mission.name}, fleet {source.mission.fleet}: {leader_text(overview)}"
        else:
            waited_s = self._clock.now_s() - self._began_s
            here = f"no vehicle of fleet {source.mission.fleet} heard for {waited_s:.0f} s at {', '.join(source.endpoints)}"
        self.query_one("#title", Static).update(here)

    def _show_rows(self, overview: Overview) -> None:
        """Only cells that changed: a terminal over a slow line is not painted anew."""
        table = self._table()
        for row in overview.rows:
            for heading, cell in zip(HEADINGS, cells_of(row, self._source.thresholds), strict=True):
                if self._shown.get((row.name, heading)) != cell:
                    self._shown[row.name, heading] = cell
                    table.update_cell(row.name, heading, Text(cell.text, LOOKS[cell.look]))

    def _show_map(self, overview: Overview) -> None:
        widget = self.query_one("#map", Static)
        columns, rows = widget.content_size.width, widget.content_size.height
        if columns < MAP_COLUMNS_MIN or rows < 2:
            widget.update("")
            return
        canvas = draw_map(self._source.mission, overview, columns, rows)
        widget.update(Text("\n").join(Text.assemble(*((text, INKS[ink]) for text, ink in line)) for line in canvas.lines()))

    def _show_order(self) -> None:
        asked = self._confirmation.asked(self._clock.now_s())
        if asked is not None:
            key = next(key for key, action in KEYS.items() if action == asked.action)
            text = Text(
                f"{asked.action.upper()} {_whom(asked, self._source.mission)}? Press {key} again to send it.", "bold reverse"
            )
        elif self._order_sent is not None:
            answers = "   ".join(f"{vehicle}: {answer}" for vehicle, answer in self._answers.items())
            text = Text(f"{self._order_sent.action}   {answers}{f'   {self._note}' if self._note else ''}")
        else:
            text = Text("no command was sent from here", "dim")
        self.query_one("#order", Static).update(text)


def _whom(order: Order, mission: Mission) -> str:
    return "the whole fleet" if len(order.vehicles) == len(mission.vehicles) else ", ".join(order.vehicles)


def _answer_text(answer: Answer) -> str:
    if answer.round_trip_s is None:
        return "NO ANSWER"
    return f"{'accepted' if answer.accepted else 'REFUSED'}, {answer.text} ({math.ceil(answer.round_trip_s * 1e3)} ms)"


def _alarms_text(overview: Overview) -> Text:
    if not overview.alarms:
        return Text("no alarm", "green")
    return Text("\n").join(
        Text(f"{alarm.level.name} {alarm.text}", "bold red" if alarm.level is Level.ALARM else "yellow")
        for alarm in overview.alarms
    )


def _events_text(overview: Overview) -> Text:
    """The newest first: what does not fit below is older."""
    lines = [f"{datetime.fromtimestamp(event.t_s, UTC):%H:%M:%S} {event.text}" for event in reversed(overview.events)]
    return Text("\n".join(lines))
