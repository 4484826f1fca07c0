"""Takes docs/images/live.png: python3 docs/images/live.py ADDRESS, of a page that was served faster than real time.

The head is a calibrated one:

    sed 's#"../heads/sphere-b.toml"#"../tests/fixtures/sphere-b-calibrated.toml"#; /^models/d' experiments/gusts.toml > experiments/live.toml
    anemo live experiments/live.toml --on sim --speed 40
"""

import io
import sys

from PIL import Image
from playwright.sync_api import sync_playwright

with sync_playwright() as playwright:
    browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
    page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme="light")
    page.goto(sys.argv[1])
    # The wind veers at 300 s; a minute of before and after is in the picture.
    while page.evaluate("now ? now.time_s : 0") < 310:
        page.wait_for_timeout(100)
    page.get_by_label("Text of the mark").fill("door opened")
    page.keyboard.press("Enter")
    page.evaluate("document.activeElement.blur()")
    while page.evaluate("now.time_s") < 328:
        page.wait_for_timeout(20)
    page.evaluate("at('answer').textContent = ''")
    picture = Image.open(io.BytesIO(page.screenshot()))
    picture.convert("RGB").quantize(256, kmeans=3, dither=Image.Dither.NONE).save("docs/images/live.png", optimize=True)
    browser.close()
