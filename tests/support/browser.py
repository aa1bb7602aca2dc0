"""A real browser for the tests of pages: Debian's chromium, chromium-driver and python3-selenium."""
import base64
import os
import re
import shutil
import sys
import time
import unittest
import urllib.parse

WIDTHS = (400, 1200, 1600)
# The name of a file that is a script where a page does not take it for text.
EVIL = "<img src=x onerror=document.title='owned'>"

CHROMIUM, DRIVER, PYTHON = "/usr/bin/chromium", "/usr/bin/chromedriver", "/usr/bin/python3"


def missing():
    """What a page cannot be tested without, or "". Starts the test anew with Debian's Python, if only that has selenium."""
    try:
        import selenium  # noqa: F401
    except ImportError:
        if os.path.realpath(sys.executable) != os.path.realpath(PYTHON) and os.path.exists(PYTHON):
            os.execv(PYTHON, [PYTHON, "-B", *sys.orig_argv[sys.orig_argv.index(sys.argv[0]):]])
        return "python3-selenium is not installed"
    for path, package in ((CHROMIUM, "chromium"), (DRIVER, "chromium-driver")):
        if not shutil.which(path):
            return package + " is not installed"
    return ""


class Browser:
    """A window without a screen."""

    def __init__(self):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(DRIVER), options=options)
        self.driver.set_page_load_timeout(120)

    def close(self):
        self.driver.quit()

    def command(self, name, **parameters):
        return self.driver.execute_cdp_cmd(name, parameters)

    def show(self, path, width=1200, height=900, dark=False, fragment=""):
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                     mobile=False)
        self.media("", dark)
        self.driver.get("about:blank")  # so that a fragment loads the page anew
        self.driver.get("file://" + urllib.parse.quote(path) + fragment)

    def media(self, medium, dark=False):
        self.command("Emulation.setEmulatedMedia", media=medium, features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def texts(self, selector):
        return self.run("return [...document.querySelectorAll(arguments[0])].filter(n => n.checkVisibility())"
                        ".map(n => n.innerText)", selector)

    def find(self, selector):
        from selenium.webdriver.common.by import By
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def press(self, *keys):
        from selenium.webdriver.common.action_chains import ActionChains
        ActionChains(self.driver).send_keys(*keys).perform()

    def point_at(self, node):
        from selenium.webdriver.common.action_chains import ActionChains
        ActionChains(self.driver).move_to_element(node).perform()

    def focused(self):
        return self.driver.switch_to.active_element

    def complaints(self):
        """What the browser has logged since the last call: errors of scripts, files that are missing."""
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def overflow(self):
        """Elements that reach beyond the right edge of the window, unless something cuts or scrolls them."""
        return self.run("""
            const wide = innerWidth, found = [];
            if (document.documentElement.scrollWidth <= wide) return found;
            for (const node of document.body.querySelectorAll("*")) {
              const right = node.getBoundingClientRect().right;
              if (right > wide + 1) found.push(`${node.tagName} ${node.className} ${node.id} ends at ${right}`);
            }
            return found.slice(0, 5).concat(`the page is ${document.documentElement.scrollWidth} wide`);""")

    def low_contrast(self):
        """Texts whose contrast with what is behind them is below 4.5, as far as plain colours decide it."""
        return self.run("""
            const canvas = new OffscreenCanvas(1, 1).getContext("2d", {willReadFrequently: true});
            const rgba = text => { canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = text; canvas.fillRect(0, 0, 1, 1);
                                   return [...canvas.getImageData(0, 0, 1, 1).data]; };
            const light = c => { const [r, g, b] = c.map(x => (x /= 255) <= .04045 ? x / 12.92 : ((x + .055) / 1.055) ** 2.4);
                                 return .2126 * r + .7152 * g + .0722 * b; };
            const found = [];
            const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
            for (let text; (text = walk.nextNode());) {
              const node = text.parentElement;
              if (!text.data.trim() || node.closest("svg, script, style, option, [disabled]") || !node.checkVisibility()) continue;
              let behind = node, color;
              while (behind && (color = rgba(getComputedStyle(behind).backgroundColor))[3] < 255) behind = behind.parentElement;
              const [a, b] = [light(rgba(getComputedStyle(node).color)), light(behind ? color : [255, 255, 255])];
              const contrast = (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
              if (contrast < 4.5) found.push(`${contrast.toFixed(2)}: ${text.data.trim().slice(0, 40)}`);
            }
            return [...new Set(found)].slice(0, 8);""")

    def pdf(self):
        """The page as printed."""
        return base64.b64decode(self.command("Page.printToPDF", printBackground=True)["data"])

    def picture(self, path):
        """Writes what the window shows, to be looked at."""
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.command("Page.captureScreenshot")["data"]))

    def thread_seconds(self):
        """Processor time of the page's main thread since `count_time`."""
        metrics = self.command("Performance.getMetrics")["metrics"]
        return next(m["value"] for m in metrics if m["name"] == "TaskDuration") - self.before

    def count_time(self):
        self.before = 0
        self.command("Performance.enable", timeDomain="threadTicks")
        self.before = self.thread_seconds()


class BrowserTest(unittest.TestCase):
    """What a page does after an event, a timer or a file it loads is waited for."""

    def assert_becomes(self, read, expected, seconds=30):
        """`read()` gives the expected value within the time; what it gave last is reported if not."""
        end = time.monotonic() + seconds
        while (value := read()) != expected and time.monotonic() < end:
            time.sleep(0.02)
        self.assertEqual(value, expected)


class Page(BrowserTest):
    """A page that `make` writes once, and what holds of every page."""
    page, browser = None, None

    @classmethod
    def setUpClass(cls):
        cls.page = cls.make()

    def show(self, **how):
        self.browser.show(self.page, **how)

    def check_everywhere(self):
        for width in WIDTHS:
            for dark in (False, True):
                with self.subTest(width=width, dark=dark):
                    self.show(width=width, dark=dark)
                    self.assertEqual(self.browser.overflow(), [])
                    self.assertEqual(self.browser.low_contrast(), [])
                    self.assertEqual(self.browser.complaints(), [])
                    if folder := os.environ.get("SIGHTLINE_PAGE_PICTURES"):
                        self.browser.picture(os.path.join(
                            folder, f"{type(self).__name__}-{width}{'-dark' if dark else ''}.png"))

    def check_print(self):
        self.show()
        self.browser.media("print")
        self.browser.run("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual([n for n in self.browser.find(".controls") if n.is_displayed()], [])
        self.browser.run("dispatchEvent(new Event('afterprint'))")
        pdf = self.browser.pdf()
        self.assertEqual(pdf[:5], b"%PDF-")
        if folder := os.environ.get("SIGHTLINE_PAGE_PICTURES"):
            with open(os.path.join(folder, type(self).__name__ + ".pdf"), "wb") as file:
                file.write(pdf)
        pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
        self.assertTrue(1 <= pages <= 30, pages)
        self.assertEqual(self.browser.complaints(), [])

    def check_names_are_text(self, selector):
        self.show()
        self.assertIn(EVIL, " ".join(self.browser.texts(selector)))
        self.assertNotEqual(self.browser.driver.title, "owned")
        self.assertEqual(self.browser.find("img[src=x]"), [])

    def check_links(self):
        """Local links lead to files, those within the page to elements; nothing is loaded from elsewhere."""
        for url in self.browser.run("""return [...document.querySelectorAll("a[href], img[src], video[src]")]
                                             .map(n => n.href || n.src)"""):
            self.assertRegex(url, "^(file|data):")
            name, _, fragment = url.partition("#")
            if fragment:
                self.assertTrue(self.browser.run("return Boolean(document.getElementById(arguments[0]))", fragment), url)
            elif url.startswith("file:"):
                self.assertTrue(os.path.exists(urllib.parse.unquote(name.removeprefix("file://"))), url)

    def column(self, table, title):
        """The texts of a column, from top to bottom."""
        return self.browser.texts(f'{table} td[data-label="{title}"]')

    def check_sorting(self, table, title, number):
        """A click on the heading sorts by the column, another one the other way round."""
        heading = next(h for h in self.browser.find(f"{table} th button") if h.text == title)
        for _ in range(2):
            heading.click()
            values = [number(t) for t in self.column(table, title)]
            order = heading.find_element("xpath", "..").get_attribute("aria-sort")
            self.assertEqual(values, sorted(values, reverse=order == "descending"))
            self.assertIn(order, ("ascending", "descending"))
        return values

    def check_copying(self, expected):
        button = next(b for b in self.browser.find("button.copy") if b.is_displayed())
        self.browser.command("Browser.grantPermissions",
                             permissions=["clipboardReadWrite", "clipboardSanitizedWrite"])
        self.browser.run("arguments[0].scrollIntoView({block: 'center'})", button)
        button.click()
        self.assert_becomes(lambda: button.text, "copied")
        text = self.browser.driver.execute_async_script(
            "navigator.clipboard.readText().then(arguments[0], e => arguments[0]('' + e))")
        self.assertRegex(text, expected)
        return text
