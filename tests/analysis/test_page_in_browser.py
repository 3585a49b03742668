"""report.html in a real browser without a window: it plays, follows clicks and keys, and no script fails.

Skipped where no Chromium is installed; `test_page.py` looks at the file in any case.
"""

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from tests.analysis.synthetic_run import MOTIONS, PURSUE_S

BROWSER = next((path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None)
WATCH = """<script>window.failures = [];
addEventListener("error", (event) => failures.push(event.message), true);
addEventListener("unhandledrejection", (event) => failures.push(String(event.reason)));
addEventListener("securitypolicyviolation", (event) => failures.push(`refused: ${event.blockedURI}`));
console.error = (...told) => failures.push(told.join(" "));
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);</script>"""
"""Frames come by the page's timers: a browser without a screen draws when it likes."""
DRIVE = """<script>(async () => {
  const told = {}, { map, player, charts } = report, pause = (ms) => new Promise((done) => setTimeout(done, ms));
  const slide = (t) => { player.slider.value = t; player.slider.dispatchEvent(new Event("input")); };
  const at = (t) => { slide(t); return structuredClone(map.drawn); };
  const key = (name) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true }));
  try {
    await pause(300);
    told.early = at(5);
    told.earlyPicture = map.canvas.toDataURL();
    told.late = at(25);
    told.pictureChanges = told.earlyPicture !== map.canvas.toDataURL();
    delete told.earlyPicture;
    told.time = document.getElementById("time").textContent;
    told.states = document.getElementById("states").textContent;
    const place = document.getElementById("chart0");
    if (!place.data) await charts.show(place);
    const cursor = place.querySelector(".cursor");
    told.cursor = [5, 25].map((t) => { at(t); return parseFloat(cursor.style.left); });
    key("ArrowRight");
    told.afterArrow = player.t;
    const button = [...document.querySelectorAll("#events button.time")].find((one) => Number(one.dataset.t) >= 0);
    button.click();
    told.clicked = [Number(button.dataset.t), player.t];
    at(5);
    player.button.click();
    for (let wait = 0; wait < 100 && player.t < 5.2; wait++) await pause(100);
    told.played = player.t;
    key(" ");
    told.paused = !player.playing;
    const visible = () => document.querySelectorAll("#events tbody tr:not([hidden])").length;
    told.rows = [visible()];
    document.querySelector("[data-level-filter=info]").click();
    told.rows.push(visible());
    told.infoShown = document.querySelectorAll("#events tr[data-level=info]:not([hidden])").length;
    const pixels = () => map.canvas.toDataURL();
    const before = pixels();
    document.querySelector("[data-layer=tracks]").click();
    told.layerChanges = before !== pixels();
    told.overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    await pause(1500);
    told.drawn = document.querySelectorAll(".js-plotly-plot").length;
  } catch (error) { failures.push(`drive: ${error.stack}`); }
  const out = document.body.appendChild(document.createElement("pre"));
  out.id = "told";
  out.textContent = JSON.stringify({ ...told, failures });
})();</script>"""


@pytest.fixture(scope="module")
def page(reported_run: Path) -> Path:
    return reported_run / "report.html"


@pytest.fixture(scope="module")
def told(page: Path) -> dict[str, Any]:
    return drive(page, 1280)


def drive(page: Path, width: int) -> dict[str, Any]:
    """What the page did when it was used, in a window `width` pixels wide."""
    if BROWSER is None:
        pytest.skip("no Chromium on this machine: the page was not run")
    text = page.read_text().replace("<meta charset", f"{WATCH}<meta charset", 1).replace("</body>", f"{DRIVE}</body>")
    driven = page.with_name(f"driven-{width}.html")
    driven.write_text(text)
    done = subprocess.run(
        [
            BROWSER,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--proxy-server=127.0.0.1:9",
            f"--user-data-dir={page.parent / f'browser-{width}'}",
            f"--window-size={width},900",
            "--virtual-time-budget=30000",
            "--dump-dom",
            driven.as_uri(),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        timeout=100,
        check=True,
    )
    found = re.search(r'<pre id="told">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found is not None, "the page's scripts did not get to their end"
    content: dict[str, Any] = json.loads(unescape(found.group(1)))
    return content


def test_no_script_fails_and_nothing_is_fetched(told: dict[str, Any]) -> None:
    assert told["failures"] == []


def test_the_slider_moves_everybody_to_where_they_were(told: dict[str, Any]) -> None:
    for moment, t_s in (("early", 5.0), ("late", 25.0)):
        assert told[moment].keys() == MOTIONS.keys()
        for name, place in told[moment].items():
            assert place == pytest.approx(MOTIONS[name].position(PURSUE_S + t_s)[:2].tolist(), abs=0.05)
    assert told["pictureChanges"]
    assert told["time"] == "25.0 s"
    assert "pursue" in told["states"]


def test_the_charts_cursor_follows(told: dict[str, Any]) -> None:
    assert told["cursor"][1] > told["cursor"][0] + 50
    assert told["drawn"] > 0


def test_keys_clicks_and_playing_move_the_time(told: dict[str, Any]) -> None:
    assert told["afterArrow"] == pytest.approx(25.2)
    assert told["clicked"][0] == pytest.approx(told["clicked"][1])
    assert told["played"] >= 5.2
    assert told["paused"]


def test_events_are_filtered_and_layers_hidden(told: dict[str, Any]) -> None:
    assert told["rows"][1] < told["rows"][0]
    assert told["infoShown"] == 0
    assert told["layerChanges"]


def test_a_telephone_shows_it_without_sideways_scrolling(told: dict[str, Any], page: Path) -> None:
    narrow = drive(page, 500)  # the narrowest window that Chromium opens
    assert narrow["failures"] == []
    assert (told["overflow"], narrow["overflow"]) == (0, 0)
