"""The live page in headless Chromium, for live_page.rs: reads what to do from stdin, prints what it saw as JSON."""

import json
import os
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

WATCH = """
window.seen = {};
const lined = () => {
    const canvas = document.querySelector("#temperature-chart canvas");
    if (!canvas) return false;
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const ink = getComputedStyle(document.documentElement).getPropertyValue("--c0").trim().slice(1);
    const [r, g, b] = [0, 2, 4].map((at) => parseInt(ink.slice(at, at + 2), 16));
    for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 9) return true;
    return false;
};
const look = () => {
    if (!seen.drawn_ms && lined()) seen.drawn_ms = performance.now();
    const alarm = document.getElementById("alarm");
    if (!seen.alarm_ms && alarm && !alarm.hidden) seen.alarm_ms = Date.now();
    if (!seen.drawn_ms || !seen.alarm_ms) requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""


def memory_mb():
    """Proportional set size of the renderers below this process."""
    parents, renderers = {}, []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(process.name)] = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
            if b"--type=renderer" in (process / "cmdline").read_bytes():
                renderers.append(int(process.name))
        except OSError:
            pass
    own = 0
    for renderer in renderers:
        above = renderer
        while above not in (0, os.getpid()):
            above = parents.get(above, 0)
        if above:
            lines = Path(f"/proc/{renderer}/smaps_rollup").read_text().splitlines()
            own += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return own / 1024


def until(page, condition):
    """Waits for it; the page's own policy forbids what Playwright would use."""
    end = time.monotonic() + 20
    while not page.evaluate(condition):
        assert time.monotonic() < end, condition
        page.wait_for_timeout(20)


def tell(**seen):
    print(json.dumps(seen), flush=True)


address, chromium = sys.argv[1:]
with sync_playwright() as playwright:
    browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    outside, errors = [], []
    page.on("request", lambda request: outside.append(request.url) if not request.url.startswith(address) else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.add_init_script(WATCH)
    page.goto(address)
    until(page, "seen.drawn_ms")
    print(f"{memory_mb():.0f} MB at first", file=sys.stderr)
    page.get_by_label("Window").select_option("3600")
    tell(drawn_ms=page.evaluate("seen.drawn_ms"), names=page.locator("body").aria_snapshot())
    for line in sys.stdin:
        match line.strip():
            case "memory":
                page.wait_for_timeout(1500)
                tell(memory_mb=memory_mb(), heap_mb=page.evaluate("performance.memory.usedJSHeapSize / 2 ** 20"), missed=page.inner_text("#missed"), lost=page.inner_text("#lost"),
                     points=page.evaluate("view.time.length"), clock=page.inner_text("#time"))
            case "trip":
                until(page, "seen.alarm_ms")
                tell(alarm_ms=page.evaluate("seen.alarm_ms"), text=page.inner_text("#alarm"),
                     wide=page.evaluate("document.documentElement.scrollWidth"))
            case "keys":
                page.evaluate("document.activeElement.blur()")
                for _ in range(20):
                    page.keyboard.press("Tab")
                    if page.evaluate("document.activeElement.textContent") == "Stop":
                        page.keyboard.press("Enter")
                        break
                until(page, "document.getElementById('answer').textContent.length > 1")
                tell(answer=page.inner_text("#answer"), outside=outside, errors=errors)
    browser.close()
